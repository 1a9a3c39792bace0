// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/controls.h"

#include <memory>

#include "scenes/replay.h"
#include "session/signals.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::controls_test {
namespace {

using pbd::Vec3;

/// A box on the ground and a plate that user 0 moves by hand.
Scene table_top(const SceneOptions& options) {
  SceneBuilder builder;
  builder.box("box", Vec3::Constant(0.1), 0.3, Vec3(0.0, 0.0, 0.05));
  BodySpec plate;
  plate.name = "plate";
  plate.parts.push_back({collision::Box{Vec3(0.2, 0.2, 0.02)}, {}});
  plate.pose.position = Vec3(1.0, 0.0, 1.0);
  plate.owner = 0;
  builder.add(plate);
  return builder.build(options, 0.5);
}

TEST_CASE("controls: inputs come back from their text with every bit", "[demos][unit]") {
  std::vector<Input> inputs;
  inputs.push_back({1,
                    12345678901234,
                    Input::Kind::Grab,
                    3,
                    4,
                    {0.1, -1.0 / 3.0, 2e-17, 4, 5, 6, 700.0, 8.25, 1e6}});
  inputs.push_back({0, -5, Input::Kind::Release, 3, 4, {}});
  inputs.push_back({0, 0, Input::Kind::Signal, 9, 0, {0.2}});
  const std::vector<Input> back = inputs_from_text(inputs_to_text(inputs));
  REQUIRE(back.size() == inputs.size());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    CHECK(back[i].user == inputs[i].user);
    CHECK(back[i].time == inputs[i].time);
    CHECK(back[i].kind == inputs[i].kind);
    CHECK(back[i].object == inputs[i].object);
    CHECK(back[i].body == inputs[i].body);
    CHECK(back[i].values == inputs[i].values);
  }
}

TEST_CASE("controls: text that is no input is refused with its line", "[demos][fault]") {
  CHECK(inputs_from_text("").empty());
  for (const char* bad : {"7", "0 0 fly 1 1", "0 0 move 1 1 0 0", "0 0 move 1 1 0 0 nan",
                          "0 0 move 1 1 0 0 1e999", "x 0 let 1 1", "0 0 drive 1 1 0 0 0 0 0 0 0"}) {
    CHECK_THROWS_WITH(inputs_from_text("0 0 let 1 1\n" + std::string(bad) + "\n"),
                      Catch::Contains("line 2"));
  }
}

TEST_CASE("controls: a driven body is at its pose after the step and says how fast it is",
          "[demos][analytic]") {
  consensus::VirtualNetwork network;
  Scene scene = table_top({});
  consensus::Peer peer(*scene.world, network.transport(1));
  for (const SceneBody& body : scene.bodies) {
    peer.share({.id = body.id, .body = body.body, .owner = std::nullopt});
  }
  Controls controls(0, scene, peer, 0);
  controls.begin(0, 0.02);
  controls.drive(1, {Vec3(1.0, 0.1, 1.0), pbd::Quat::Identity()});
  pbd::Solver solver;
  static_cast<void>(solver.step(*scene.world, 0.02));
  CHECK((scene.pose(1).position - Vec3(1.0, 0.1, 1.0)).norm() < 1e-12);
  CHECK((scene.twist(1).linear - Vec3(0.0, 5.0, 0.0)).norm() < 1e-9);
  CHECK(controls.log().size() == 1);
}

TEST_CASE("controls: a user holds a grabbed body at its point until letting go", "[demos][unit]") {
  consensus::VirtualNetwork network;
  Scene scene = table_top({});
  consensus::Peer peer(*scene.world, network.transport(1));
  for (const SceneBody& body : scene.bodies) {
    peer.share({.id = body.id, .body = body.body, .owner = std::nullopt});
  }
  Controls controls(0, scene, peer, 0);
  controls.begin(0, 0.02);
  const Vec3 corner(0.05, -0.05, 0.05);
  const std::uint32_t spring = controls.grab(0, {.attachment_l = corner, .anchor_w = corner});
  controls.move(spring, Vec3(1.0, 0.0, 1.0));
  CHECK(controls.holds(0));
  CHECK(controls.holds(0, corner));
  CHECK_FALSE(controls.holds(0, Vec3::Zero()));
  CHECK_FALSE(controls.holds(1, corner));
  controls.release(spring);
  CHECK_FALSE(controls.holds(0, corner));
}

TEST_CASE("controls: only the peer of its user drives a body", "[demos][unit]") {
  const Scene here = table_top({.users = 1});
  const Scene there = table_top({.users = 2});
  CHECK(here.world->props(here.bodies[1].body).type == pbd::BodyType::Kinematic);
  CHECK(there.world->props(there.bodies[1].body).type == pbd::BodyType::Dynamic);
  CHECK(scene_hash(here) == scene_hash(there));
}

TEST_CASE("signals: each takes effect once at each peer, at its time", "[demos][unit]") {
  consensus::LinkOptions link;
  link.latency = 0.05;
  consensus::VirtualNetwork network(link);
  Signals a(network.transport(1));
  Signals b(network.transport(2));
  a.update(0);
  b.update(0);
  a.raise({7, 100'000'000});
  Signal signal;
  CHECK_FALSE(a.take(99'999'999, signal));
  CHECK(a.take(100'000'000, signal));
  CHECK(signal.code == 7);
  CHECK_FALSE(a.take(200'000'000, signal));
  std::vector<consensus::Packet> packets;
  network.advance_to(60'000'000);
  b.drain(packets);
  CHECK(packets.empty());  // it is nothing for the peer
  CHECK(b.take(100'000'000, signal));
  CHECK_FALSE(b.take(100'000'000, signal));
}

TEST_CASE("signals: late peers are told", "[demos][unit]") {
  consensus::VirtualNetwork network;
  Signals a(network.transport(1));
  a.update(0);
  a.raise({7, 5});
  Signals b(network.transport(2));
  a.update(10);
  b.update(10);
  network.advance_to(20);
  std::vector<consensus::Packet> packets;
  b.drain(packets);
  Signal signal;
  CHECK(b.take(20, signal));
  CHECK(signal.time == 5);
}

}  // namespace
}  // namespace tandem::demos::controls_test
