// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Targets in worlds of several islands: some sleep, some take more substeps than others.
#include <algorithm>

#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"

namespace pose_target_group_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// A jointed pair on the floor that agrees with its target, and a body that flies past.
struct SleepingPair {
  World world;
  ToyContacts contacts;
  FixedTargets targets;
  JointBlock& joints = world.add_block<JointBlock>();
  DistanceJoints& rods = world.add_block<DistanceJoints>();
  BodyId a, b;
  Solver solver;

  SleepingPair() {
    world.set_contact_source(&contacts);
    world.set_target_source(&targets);
    const Vec3 half = Vec3::Constant(0.25);
    const BodyId ground = add_ground(world);
    a = world.add_body(box_def(1.0, half, Vec3(0.0, 0.0, 0.25)));
    b = world.add_body(box_def(1.0, half, Vec3(0.6, 0.0, 0.25)));
    for (const BodyId id : {a, b}) contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, id, half, {});
    joints.add(world, ball_joint_at(world, a, b, Vec3(0.3, 0.0, 0.25)));
    rods.add(world, {.a = a, .b = b, .rest_length = 0.6});
    BodyDef flying = ball_def(1.0, 0.1, Vec3(0.0, 5.0, 5.0));
    flying.gravity_scale = 0.0;
    flying.twist.linear = Vec3(1.0, 0.0, 0.0);
    world.add_body(flying);
    targets.targets.push_back({.body = b,
                               .pose = {Vec3(0.6005, 0.0, 0.25), Quat::Identity()},
                               .share = 0.5,
                               .motion = TargetMotion::Inertial});
  }
};

}  // namespace

TEST_CASE(
    "pose_target: sleepers are out of the displacement channel, so a restored world continues",
    "[pbd][consensus][golden]") {
  SleepingPair straight;
  run(straight.world, straight.solver, 2.0);
  REQUIRE_FALSE(straight.world.awake(straight.b));
  SleepingPair fresh;
  fresh.world.restore(straight.world.snapshot());
  for (int i = 0; i < 3; ++i) {
    straight.solver.step(straight.world, kFrame);
    fresh.solver.step(fresh.world, kFrame);
    CHECK(fresh.world.snapshot() == straight.world.snapshot());
  }
}

TEST_CASE("pose_target: without its source no correction is reported", "[pbd][consensus][unit]") {
  SleepingPair scene;
  run(scene.world, scene.solver, 0.05);
  REQUIRE(scene.world.correction(scene.b).translation.norm() > 0.0);
  scene.world.set_target_source(nullptr);
  scene.solver.step(scene.world, kFrame);
  CHECK(scene.world.correction(scene.b).translation.norm() == 0.0);
}

TEST_CASE("pose_target: an island agrees as if no other group were solved",
          "[pbd][consensus][unit]") {
  // Three rods under a hook, pulled by a target; others turn fast and get more substeps.
  Vec3 place[2];
  for (const bool other : {false, true}) {
    World world(weightless());
    FixedTargets targets;
    world.set_target_source(&targets);
    auto& joints = world.add_block<JointBlock>();
    const auto add = [&](double x, double spin) {
      BodyId last;
      for (int k = 0; k < 3; ++k) {
        const BodyId body =
            world.add_body(box_def(1.0, Vec3(0.1, 0.1, 0.5), Vec3(x, 0.0, -0.5 - k)));
        joints.add(world, ball_joint_at(world, last, body, Vec3(x, 0.0, -k), Vec3::UnitZ()));
        world.set_twist(body, {Vec3::Zero(), Vec3(0.0, 0.0, spin)});
        last = body;
      }
      targets.targets.push_back({.body = last,
                                 .pose = {Vec3(x + 3.0, 0.0, -1.4), Quat::Identity()},
                                 .share = 0.2,
                                 .motion = TargetMotion::Inertial});
      return last;
    };
    const BodyId body = add(0.0, 0.0);
    if (other) add(5.0, 40.0);
    // One iteration leaves a debt, which is each group's own.
    Solver solver({.sleep_after = 0.0});
    int groups = 0;
    for (int i = 0; i < 60; ++i) groups = std::max(groups, solver.step(world, kFrame).groups);
    REQUIRE(groups == (other ? 2 : 1));
    place[other ? 1 : 0] = world.pose(body).position;
  }
  CHECK((place[1] - place[0]).norm() < 1e-12);
}

}  // namespace pose_target_group_test
