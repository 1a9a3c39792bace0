// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/rendezvous.h"

#include <vector>

#include "scenes/cubes.h"
#include "session/remote_view.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/bytes.h"

namespace tandem::demos::rendezvous_test {
namespace {

using consensus::SessionTime;

constexpr SessionTime kMs = 1'000'000;

Scene small_scene() {
  SceneBuilder builder;
  builder.box("box", pbd::Vec3::Constant(0.1), 1.0, pbd::Vec3(0.0, 0.0, 0.05));
  return builder.build({}, 0.5);
}

struct Node {
  Node(consensus::VirtualNetwork& network, consensus::PeerId id, const Scene& scene,
       consensus::TimestampSource timestamps = consensus::TimestampSource::Sender)
      : view(scene), rendezvous(network.transport(id), view, timestamps) {}
  void poll(SessionTime now) {
    rendezvous.drain(packets);
    rendezvous.update(now);
  }
  RemoteView view;
  Rendezvous rendezvous;
  std::vector<consensus::Packet> packets;
};

TEST_CASE("rendezvous: all agree on one epoch, and no word of it gets through", "[demos][unit]") {
  const Scene scene = small_scene();
  consensus::VirtualNetwork network({.latency = 0.1}, 1);
  for (consensus::PeerId id = 1; id <= 3; ++id) network.transport(id);
  Node a(network, 1, scene), b(network, 2, scene), c(network, 3, scene);
  for (SessionTime now = 0; now < 3000 * kMs; now += 16 * kMs) {
    network.advance_to(now);
    a.poll(now);
    b.poll(now);
    c.poll(now);
  }
  REQUIRE(a.rendezvous.epoch().has_value());
  CHECK(a.rendezvous.epoch() == b.rendezvous.epoch());
  CHECK(a.rendezvous.epoch() == c.rendezvous.epoch());
  CHECK(a.packets.empty());
  CHECK(b.packets.empty());

  SECTION("a late or returning peer adopts the running epoch, the lowest id too") {
    Node again(network, 1, scene);
    for (SessionTime now = 3000 * kMs; now < 4500 * kMs; now += 16 * kMs) {
      network.advance_to(now);
      again.poll(now);
      b.poll(now);
      c.poll(now);
    }
    CHECK(again.rendezvous.epoch() == b.rendezvous.epoch());
  }
}

TEST_CASE("rendezvous: without a common time the epoch is one moment all the same",
          "[demos][unit]") {
  const Scene scene = small_scene();
  consensus::VirtualNetwork network({.latency = 0.1}, 1);
  constexpr SessionTime kAhead = 7'200'000 * kMs;
  for (consensus::PeerId id = 1; id <= 2; ++id) network.transport(id);
  network.set_clock(2, kAhead);
  Node a(network, 1, scene, consensus::TimestampSource::Arrival);
  Node b(network, 2, scene, consensus::TimestampSource::Arrival);
  for (SessionTime now = 0; now < 3000 * kMs; now += 16 * kMs) {
    network.advance_to(now);
    // Round trips are those of states.
    for (consensus::PeerId id = 1; id <= 2; ++id) {
      network.transport(id).post(3 - id, std::vector<std::byte>(9), consensus::Delivery::Newest);
    }
    a.poll(now);
    b.poll(now + kAhead);
  }
  REQUIRE(a.rendezvous.epoch().has_value());
  REQUIRE(b.rendezvous.epoch().has_value());
  CHECK(*b.rendezvous.epoch() - kAhead == *a.rendezvous.epoch());
}

TEST_CASE("rendezvous: alone there is no epoch", "[demos][unit]") {
  const Scene scene = small_scene();
  consensus::VirtualNetwork network({}, 1);
  Node a(network, 1, scene);
  for (SessionTime now = 0; now < 3000 * kMs; now += 16 * kMs) {
    network.advance_to(now);
    a.poll(now);
  }
  CHECK_FALSE(a.rendezvous.epoch().has_value());
  CHECK_FALSE(a.rendezvous.connected());
}

TEST_CASE("rendezvous: an epoch of another day is not taken over", "[demos][fault]") {
  const Scene scene = small_scene();
  consensus::VirtualNetwork network({}, 1);
  network.transport(2);
  Node a(network, 3, scene);  // not the lowest: it would only take over
  std::vector<std::byte> word;
  pbd::ByteWriter out(word);
  out.u32(0x4f4d4454);
  out.i64(INT64_MAX - 1);
  out.i64(0);
  network.transport(2).post(3, word, consensus::Delivery::Newest);
  for (SessionTime now = kMs; now < 100 * kMs; now += 16 * kMs) {
    network.advance_to(now);
    a.poll(now);
  }
  CHECK_FALSE(a.rendezvous.epoch().has_value());
}

TEST_CASE("remote view: tracks hold sent states at their stamps, with the hands", "[demos][unit]") {
  const Scene scene = small_scene();
  RemoteView view(scene);
  consensus::StateUpdate state;
  state.id = scene.bodies[0].id;
  state.pose.position = pbd::Vec3(1.0, 2.0, 3.0);
  state.twist.linear = pbd::Vec3(0.0, 3.0, 4.0);
  state.stamp = 10 * kMs;
  consensus::SpringUpdate spring;
  spring.spring = 1;
  spring.revision = 1;
  spring.body = state.id;
  spring.stiffness = 10.0;
  spring.max_force = 1.0;
  std::vector<std::byte> packet;
  consensus::encode({&spring, 1}, packet);
  consensus::encode({&state, 1}, packet);
  view.look(7, packet);

  packet.clear();
  spring.event = consensus::SpringEvent::Remove;
  spring.revision = 2;
  state.stamp = 20 * kMs;
  consensus::encode({&spring, 1}, packet);
  consensus::encode({&state, 1}, packet);
  view.look(7, packet);
  view.look(7, std::vector<std::byte>(9, std::byte{0x55}));  // no packet at all

  const std::vector<PeerRecord> records = view.records();
  REQUIRE(records.size() == 1);
  CHECK(records[0].id == 7);
  CHECK_FALSE(records[0].local);
  const std::vector<TrackSample>& samples = records[0].tracks.at(0).samples();
  REQUIRE(samples.size() == 2);
  CHECK(samples[0].time == 10 * kMs);
  CHECK(samples[0].position == pbd::Vec3(1.0, 2.0, 3.0));
  CHECK(samples[0].speed == Approx(5.0));
  CHECK(samples[0].users == 1);
  CHECK(samples[1].users == 0);
}

TEST_CASE("remote view: packets under way do not bring back a hand that has let go",
          "[demos][unit]") {
  const Scene scene = small_scene();
  RemoteView view(scene);
  consensus::StateUpdate state;
  state.id = scene.bodies[0].id;
  consensus::SpringUpdate spring;
  spring.body = state.id;
  spring.stiffness = 10.0;
  spring.max_force = 1.0;
  SessionTime now = 0;
  const auto say = [&](std::uint32_t number, std::uint32_t revision, consensus::SpringEvent event) {
    spring.spring = number;
    spring.revision = revision;
    spring.event = event;
    state.stamp = now += kMs;
    std::vector<std::byte> packet;
    consensus::encode({&spring, 1}, packet);
    consensus::encode({&state, 1}, packet);
    view.look(7, packet);
    return view.records().at(0).tracks.at(0).samples().back().users;
  };
  using consensus::SpringEvent;
  CHECK(say(1, 1, SpringEvent::Create) == 1);
  CHECK(say(1, 9, SpringEvent::Remove) == 0);
  // States of the spring that were sent before come later, by another way.
  CHECK(say(1, 8, SpringEvent::Change) == 0);
  CHECK(say(2, 1, SpringEvent::Create) == 1);
  CHECK(say(2, 2, SpringEvent::Remove) == 0);
  // However many there have been, the next one counts.
  for (std::uint32_t number = 3; number < 600; ++number) {
    CHECK(say(number, 1, SpringEvent::Create) == 1);
    CHECK(say(number, 2, SpringEvent::Remove) == 0);
  }
}

}  // namespace
}  // namespace tandem::demos::rendezvous_test
