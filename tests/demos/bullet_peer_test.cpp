// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Another engine as a peer of a session, [friston] Sec. 7.13.
#include <algorithm>
#include <cmath>

#include "measures/metrics.h"
#include "runner/virtual_runner.h"
#include "runs.h"
#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "session/physics.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"

namespace tandem::demos::bullet_peer_test {
namespace {

constexpr double kStep = 1.0 / 60.0;
constexpr consensus::SessionTime kBegin = 1'000'000'000;

/// Says so where there is nothing to test.
bool skipped() {
  if (!has_bullet()) WARN("skipped: built without Bullet (TANDEM_BULLET_PEER)");
  return !has_bullet();
}

/// Cubes of 0.3 kg on the ground, on that one and in the air, at one peer that runs on Bullet.
class Alone {
 public:
  Alone() : network_({}, 1, kBegin) {
    SceneBuilder builder;
    const pbd::Vec3 edge = pbd::Vec3::Constant(0.1);
    builder.box("rests", edge, 0.3, {0.0, 0.0, 0.05});
    builder.box("flies", edge, 0.3, {1.0, 0.0, 2.0});
    builder.box("on it", edge, 0.3, {0.0, 0.0, 0.15});
    scene_ = builder.build({}, 0.5);
    consensus::PeerOptions options{.coupling = consensus::Coupling::TwoStep};
    peer_ = std::make_unique<consensus::Peer>(*scene_.world, network_.transport(1), options);
    for (const SceneBody& body : scene_.bodies) peer_->share({.id = body.id, .body = body.body});
    physics_ = make_physics(Engine::Bullet, scene_);
  }
  void step() {
    peer_->before_step(now_);
    CHECK(physics_->step(scene_, *peer_, kStep).status == pbd::StepStatus::Ok);
    now_ += std::llround(1e9 * kStep);
    peer_->after_step(now_);
  }
  Scene& scene() { return scene_; }
  consensus::Peer& peer() { return *peer_; }
  const Physics& physics() const { return *physics_; }

 private:
  consensus::VirtualNetwork network_;
  Scene scene_;
  std::unique_ptr<consensus::Peer> peer_;
  std::unique_ptr<Physics> physics_;
  consensus::SessionTime now_ = kBegin;
};

TEST_CASE("bullet peer: the view falls, rests and touches as Bullet has it", "[demos][analytic]") {
  if (skipped()) return;
  Alone alone;
  for (int i = 0; i < 30; ++i) alone.step();
  // Semi-implicit Euler: g dt^2 n (n + 1) / 2.
  CHECK(alone.scene().pose(1).position.z() ==
        Approx(2.0 - 9.81 * kStep * kStep * 30 * 31 / 2).epsilon(1e-9));
  CHECK(alone.scene().twist(1).linear.z() == Approx(-9.81 * 0.5).epsilon(1e-9));
  // Bullet lets boxes sink into each other by some of its margin.
  CHECK(alone.scene().pose(0).position.z() == Approx(0.05).margin(2e-3));
  // The ground is not shared.
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  CHECK(*alone.physics().touching() == Pairs{{0, 2}});
}

TEST_CASE("bullet peer: a teleported body keeps its velocity", "[demos][analytic]") {
  if (skipped()) return;
  Alone alone;
  for (int i = 0; i < 10; ++i) alone.step();
  const pbd::BodyId flies = alone.scene().bodies[1].body;
  pbd::BodyState state = alone.scene().world->state(flies);
  state.pose.position.x() += 0.2;
  alone.scene().world->set_pose(flies, state.pose);
  alone.step();
  CHECK(alone.scene().pose(1).position.x() == Approx(1.2).epsilon(1e-12));
  CHECK(alone.scene().twist(1).linear.x() == 0.0);
  CHECK(alone.scene().twist(1).linear.z() == Approx(-9.81 * 11 * kStep).epsilon(1e-9));
  // And what is given another velocity has that.
  alone.scene().world->set_twist(flies, {pbd::Vec3(0.5, 0.0, 0.0), pbd::Vec3::Zero()});
  alone.step();
  CHECK(alone.scene().pose(1).position.x() == Approx(1.2 + 0.5 * kStep).epsilon(1e-12));
}

TEST_CASE("bullet peer: a user's spring holds a cube at m g / k below the hand, however stiff",
          "[demos][analytic]") {
  if (skipped()) return;
  for (const double stiffness : {30.0, 500.0, 1e6}) {
    Alone alone;
    const pbd::Vec3 hand(1.0, 0.0, 2.0);
    const consensus::GrabId grab = alone.peer().grab({.body = alone.scene().bodies[1].id,
                                                      .attachment_l = {0.0, 0.0, 0.05},
                                                      .anchor_w = hand,
                                                      .stiffness = stiffness});
    for (int i = 0; i < 600; ++i) alone.step();
    CHECK(alone.scene().pose(1).position.z() + 0.05 ==
          Approx(hand.z() - 0.3 * 9.81 / stiffness).margin(1e-4));
    CHECK(alone.scene().twist(1).linear.norm() < 1e-3);
    alone.peer().release(grab);
    alone.step();
    alone.step();
    CHECK(alone.scene().twist(1).linear.z() < -9.81 * kStep);
  }
}

TEST_CASE("bullet peer: scenes that it cannot hold are refused by name", "[demos][fault]") {
  if (skipped()) return;
  SceneBuilder builder;
  BodySpec spec;
  spec.name = "table";
  spec.parts.push_back({collision::Box{}, {{0.0, 0.0, 0.5}, pbd::Quat::Identity()}});
  spec.parts.push_back({collision::Box{}, {{0.0, 0.0, -0.5}, pbd::Quat::Identity()}});
  builder.add(spec);
  const Scene scene = builder.build({});
  CHECK_THROWS_WITH(make_physics(Engine::Bullet, scene),
                    Catch::Contains("table must be one shape"));
}

DemoOptions mixed(int profile, double seconds) {
  DemoOptions options = quiet(profile, seconds);
  options.engines = {Engine::Tandem, Engine::Bullet};
  options.rates = {60.0, 72.0};
  return options;
}

TEST_CASE("bullet peer: it and a Tandem peer hold one session of cubes, at different rates",
          "[demos][soak]") {
  if (skipped()) return;
  const int profile = GENERATE(1, 3);
  const RunResult run = run_virtual(CubesScenario(), mixed(profile, 20.0));
  const Metrics metrics = evaluate(run.peers);
  CAPTURE(profile, run.peers[0].fault, run.peers[1].fault);
  CHECK(metrics.divergence_m.p50 < 2e-3);
  CHECK(metrics.divergence_m.p95 < 2e-2);
  for (const PeerRecord& peer : run.peers) {
    CHECK(number(peer, "plate_lifted_m") > 0.2);
    CHECK(number(peer, "cubes_on_plate") >= 12.0);
    CHECK(peer.updates_received > 0);
  }
  CHECK(number(run.peers[0], "a_tasks_done") == 2.0);
  CHECK(number(run.peers[1], "b_tasks_done") == 2.0);
}

TEST_CASE("bullet peer: the balls of the cliff come to rest at both", "[demos][soak]") {
  if (skipped()) return;
  const RunResult run = run_virtual(CliffScenario(40), mixed(1, 8.0));
  for (const PeerRecord& peer : run.peers) CHECK(peer.fault.empty());
  CHECK(evaluate(run.peers).divergence_m.p50 < 0.02);
}

}  // namespace
}  // namespace tandem::demos::bullet_peer_test
