// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/user.h"

#include <memory>

#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::user_test {
namespace {

using consensus::SessionTime;
using pbd::Vec3;

/// One box on the ground and a peer without company.
struct Bench {
  Bench() {
    SceneBuilder builder;
    builder.box("box", Vec3::Constant(0.1), 0.3, Vec3(0.0, 0.0, 0.05));
    scene = builder.build({}, 0.5);
    peer = std::make_unique<consensus::Peer>(*scene.world, network.transport(1));
    peer->share({.id = scene.bodies[0].id, .body = scene.bodies[0].body, .owner = std::nullopt});
    controls = std::make_unique<Controls>(0, scene, *peer, 0);
  }
  /// Run to the session time `end` (s).
  void run(User& user, double end) {
    while (now < static_cast<SessionTime>(end * 1e9)) {
      controls->begin(now, 1.0 / 64.0);
      user.update(now);
      peer->before_step(now);
      solver.step(*scene.world, 1.0 / 64.0);
      now += 15'625'000;  // 1/64 s
      peer->after_step(now);
    }
  }
  Vec3 position() const { return scene.pose(scene.bodies[0]).position; }
  ScriptedUser user(double start, const HandPath& path, double tremor = 0.0) {
    HandTask task;
    task.start = start;
    task.plan = [path]() {
      return HandPlan{0, GripSpec::for_load(0.3, Vec3(0.04, 0.04, 0.0)), path};
    };
    UserOptions options;
    options.tremor = tremor;
    return ScriptedUser(*controls, options, {task});
  }

  consensus::VirtualNetwork network;
  Scene scene;
  std::unique_ptr<consensus::Peer> peer;
  std::unique_ptr<Controls> controls;
  pbd::Solver solver;
  SessionTime now = 0;
};

TEST_CASE("user: a held box hangs 1 cm below the hand and stays level", "[demos][analytic]") {
  Bench bench;
  HandPath path(0.0, Vec3(0.0, 0.0, 0.05));
  path.wait(0.2).move_by(Vec3(0.2, 0.0, 0.3), 1.0).wait(5.0);
  ScriptedUser user = bench.user(0.5, path);
  bench.run(user, 0.4);
  CHECK_FALSE(bench.controls->holds(0));
  bench.run(user, 4.0);
  REQUIRE(bench.controls->holds(0));
  CHECK(bench.peer->held(bench.scene.bodies[0].id));
  CHECK(bench.position().x() == Approx(0.2).margin(1e-4));
  CHECK(bench.position().z() == Approx(0.35 - 0.01).margin(1e-4));
  const Vec3 up = bench.scene.pose(bench.scene.bodies[0]).orientation * Vec3::UnitZ();
  CHECK(up.z() > 0.9999);
}

TEST_CASE("user: lets go at the end of the path", "[demos][unit]") {
  Bench bench;
  HandPath path(0.0, Vec3(0.0, 0.0, 0.05));
  path.move_by(Vec3(0.0, 0.0, 0.2), 0.8);
  ScriptedUser user = bench.user(0.1, path);
  bench.run(user, 3.0);
  CHECK_FALSE(bench.controls->holds(0));
  CHECK_FALSE(bench.peer->held(bench.scene.bodies[0].id));
  CHECK(bench.position().z() == Approx(0.05).margin(1e-3));  // it fell back
}

TEST_CASE("user: a task that is long over is skipped", "[demos][unit]") {
  Bench bench;
  HandPath path(0.0, Vec3(0.0, 0.0, 0.05));
  path.move_by(Vec3(0.0, 0.0, 0.2), 8.0);
  ScriptedUser user = bench.user(1.0, path);
  bench.now = 2'000'000'000;
  bench.run(user, 3.0);
  CHECK_FALSE(bench.controls->holds(0));
}

TEST_CASE("user: lets go of a body that does not follow the hand", "[demos][unit]") {
  Bench bench;
  HandPath path(0.0, Vec3(0.0, 0.0, 0.05));
  path.move_by(Vec3(0.0, 0.0, -2.0), 2.0).wait(10.0);  // into the ground
  ScriptedUser user = bench.user(0.0, path);
  bench.run(user, 4.0);
  CHECK_FALSE(bench.controls->holds(0));
  CHECK(bench.position().z() == Approx(0.05).margin(1e-3));
}

}  // namespace
}  // namespace tandem::demos::user_test
