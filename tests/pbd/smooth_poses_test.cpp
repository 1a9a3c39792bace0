// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/smooth_poses.h"

#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::pbd::smooth_poses_test {

using tandem::testing::ball_def;
using tandem::testing::kFrame;
using tandem::testing::names;
using tandem::testing::refusal;
using tandem::testing::weightless;

TEST_CASE("smooth poses: 1 is the world's pose, 0 that of the step before", "[pbd][smooth]") {
  World world;
  Solver solver;
  BodyDef def = ball_def(1.0, 0.1, Vec3(0.0, 0.0, 3.0));
  def.twist = {Vec3(1.0, 2.0, 0.0), Vec3(0.0, 0.0, 2.0)};
  const BodyId ball = world.add_body(def);
  SmoothPoses shown;
  Pose before = world.pose(ball);
  for (int i = 0; i < 30; ++i) {
    solver.step(world, kFrame);
    shown.after_step(world, kFrame);
    const Pose& now = world.pose(ball);
    CHECK(shown.at(ball, 1.0).position == now.position);
    CHECK(shown.at(ball, 1.0).orientation.coeffs() == now.orientation.coeffs());
    CHECK(shown.at(ball, 7.0).position == now.position);
    if (i > 0) {
      CHECK((shown.at(ball, 0.0).position - before.position).norm() == 0.0);
      const Pose half = shown.at(ball, 0.5);
      CHECK((half.position - 0.5 * (before.position + now.position)).norm() < 1e-15);
      // About a fixed axis half of the step is half of the angle.
      CHECK(half.orientation.angularDistance(before.orientation) == Approx(kFrame).epsilon(1e-9));
    }
    before = now;
  }
}

TEST_CASE("smooth poses: jumps are blended over, long ones are not", "[pbd][smooth]") {
  World world(weightless());
  Solver solver;
  const BodyId ball = world.add_body(ball_def(1.0, 0.1, Vec3::Zero()));
  SmoothPoses shown({.blend = 0.1, .snap = 1.0});
  const auto step = [&] {
    solver.step(world, kFrame);
    shown.after_step(world, kFrame);
  };
  step();
  world.set_pose(ball, {Vec3(0.5, 0.0, 0.0), Quat(Eigen::AngleAxisd(1.0, Vec3::UnitX()))});
  double behind = 0.5;
  double turn = 1.0;
  for (int i = 0; i < 60; ++i) {
    step();
    behind *= std::exp(-kFrame / 0.1);
    turn *= std::exp(-kFrame / 0.1);
    const Pose pose = shown.at(ball, 1.0);
    CHECK(pose.position.x() == Approx(0.5 - behind).margin(1e-12));
    CHECK(pose.orientation.angularDistance(world.pose(ball).orientation) ==
          Approx(turn).margin(1e-7));
  }
  world.set_pose(ball, {Vec3(2.0, 0.0, 0.0), Quat::Identity()});
  step();
  CHECK(shown.at(ball, 0.0).position.x() == 2.0);
  CHECK(shown.at(ball, 1.0).position.x() == 2.0);
}

TEST_CASE("smooth poses: bodies come and go", "[pbd][smooth]") {
  World world(weightless());
  Solver solver;
  SmoothPoses shown({.blend = 0.0});
  const BodyId first = world.add_body(ball_def(1.0, 0.1, Vec3::Zero()));
  CHECK(names(refusal([&] { shown.at(first, 0.5); }), "body", "0", "after_step"));
  shown.after_step(world, kFrame);
  CHECK(shown.at(first, 0.5).position == Vec3::Zero());
  world.remove_body(first);
  const BodyId second = world.add_body(ball_def(1.0, 0.1, Vec3::UnitX()));
  REQUIRE(second.index == first.index);
  shown.after_step(world, kFrame);
  CHECK(shown.at(second, 0.0).position == Vec3::UnitX());
  CHECK_FALSE(refusal([&] { shown.at(first, 0.5); }).empty());
  world.set_pose(second, {Vec3::UnitY(), Quat::Identity()});
  solver.step(world, kFrame);
  shown.after_step(world, kFrame);
  CHECK(shown.at(second, 1.0).position == Vec3::UnitY());  // no blend
  CHECK(names(refusal([] { SmoothPoses({.blend = -1.0}); }), "blend", "-1", ">= 0"));
  CHECK(names(refusal([] { SmoothPoses({.snap = 0.0}); }), "snap", "0", "> 0"));
  CHECK(names(refusal([&] { shown.after_step(world, 0.0); }), "dt", "0", "> 0"));
}

}  // namespace tandem::pbd::smooth_poses_test
