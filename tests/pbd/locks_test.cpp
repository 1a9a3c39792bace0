// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies some of whose axes are locked, alone and with everything that may act on them.
#include "joint_fixture.h"
#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"

namespace locks_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr AxisLocks kOnlyY{.angular = {true, false, true}};

/// Moments of inertia 1, 5, 5, turned by 45 degrees about z: I_yy = (1 + 5) / 2 in the world.
BodyDef tilted() {
  BodyDef def;
  def.pose.orientation = turn(Vec3(0.0, 0.0, 0.25 * kPi));
  def.inertia = Vec3(1.0, 5.0, 5.0).asDiagonal();
  def.locks = kOnlyY;
  return def;
}

}  // namespace

TEST_CASE("locks: a torque about the one free axis meets the inertia about that axis",
          "[pbd][locks][analytic]") {
  World world(weightless());
  const BodyId body = world.add_body(tilted());
  Solver solver;
  world.apply_torque(body, Vec3(7.0, 6.0, 5.0));
  solver.step(world, 1e-3);
  CHECK((world.twist(body).angular - Vec3(0.0, 6.0 / 3.0 * 1e-3, 0.0)).norm() < 1e-9);
}

TEST_CASE("locks: an impulse changes the free motions, by the free inertia",
          "[pbd][locks][analytic]") {
  World world(weightless());
  BodyDef def = tilted();
  def.locks.linear = {true, false, false};
  const BodyId body = world.add_body(def);
  world.apply_angular_impulse(body, Vec3(7.0, 6.0, 5.0));
  CHECK((world.twist(body).angular - Vec3(0.0, 2.0, 0.0)).norm() < 1e-12);
  // (2, 0, 3) N s at (0, 0, 1.5) m: a moment of 3 N m s about y, and nothing along x.
  world.apply_impulse(body, Vec3(2.0, 0.0, 3.0), Vec3(0.0, 0.0, 1.5));
  CHECK((world.twist(body).angular - Vec3(0.0, 3.0, 0.0)).norm() < 1e-12);
  CHECK((world.twist(body).linear - Vec3(0.0, 0.0, 3.0)).norm() < 1e-12);
}

TEST_CASE("locks: a hub with a locked axis holds its joints", "[pbd][locks][joint][unit]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  BodyDef def = ball_def(5.0, 0.5, Vec3::Zero());
  def.locks.angular = {true, false, false};
  const BodyId hub = world.add_body(def);
  std::vector<JointId> ids{joints.add(world, ball_joint_at(world, {}, hub, Vec3::Zero()))};
  for (int i = 0; i < 9; ++i) {
    const double angle = 2.0 * kPi * i / 9.0;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    const BodyId arm = world.add_body(ball_def(1.0 + 0.1 * i, 0.1, 0.8 * out));
    ids.push_back(joints.add(world, ball_joint_at(world, hub, arm, 0.5 * out)));
  }
  Solver solver({.sleep_after = 0.0});
  double separation = 0.0;
  double turned = 0.0;
  run(world, solver, 1.0, [&] {
    for (const JointId id : ids) separation = std::max(separation, joints.at(id).residual);
    turned = std::max(turned, std::abs(world.twist(hub).angular.x()));
  });
  REQUIRE(solver.step(world, kFrame).status == StepStatus::Ok);
  CHECK(separation < 1e-5);
  CHECK(turned == 0.0);
  CHECK(world.twist(hub).angular.norm() > 1e-3);  // the arms are not balanced
}

TEST_CASE("locks: a hub that is fixed to a body that cannot turn cannot turn either",
          "[pbd][locks][joint][unit]") {
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  const BodyId hub = world.add_body(ball_def(5.0, 0.5, Vec3::Zero()));
  for (int i = 0; i < 9; ++i) {
    const double angle = 2.0 * kPi * i / 9.0;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    BodyDef arm = ball_def(1.0, 0.1, 0.8 * out);
    arm.twist.linear = Vec3(0.0, 0.0, 1.0).cross(out) + Vec3(0.0, 0.0, 0.1 * i);
    joints.add(world, ball_joint_at(world, hub, world.add_body(arm), 0.5 * out));
  }
  BodyDef upright = ball_def(1.0, 0.1, Vec3(0.0, 0.0, 1.0));
  upright.locks.angular = {true, true, true};
  const BodyId held = world.add_body(upright);
  const JointId fixed = joints.add(world, fixed_joint_at(world, hub, held, Vec3(0.0, 0.0, 0.5)));
  Solver solver({.sleep_after = 0.0});
  double turned = 0.0;
  run(world, solver, 1.0, [&] {
    turned = std::max(turned, angle_between(world.pose(hub).orientation, Quat::Identity()));
  });
  CHECK(turned < 1e-6);
  CHECK(joints.at(fixed).residual < 1e-6);
}

TEST_CASE("locks: an overlap does not push a body along a locked axis", "[pbd][locks][contact]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const Vec3 half = Vec3::Constant(0.5);
  const BodyId wall = add_ground(world);
  BodyDef def = box_def(1.0, half, Vec3(0.45, 0.0, 0.5));
  def.locks.linear = {true, false, false};
  const BodyId box = world.add_body(def);
  contacts.box_on_plane(wall, Vec3::UnitX(), 0.0, box, half, {.friction = 0.0});
  contacts.box_on_plane(wall, Vec3::UnitZ(), 0.0, box, half, {});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 1.0, [&] { REQUIRE(world.pose(box).position.x() == 0.45); });
}

TEST_CASE("locks: agreement moves no locked axis", "[pbd][locks][consensus]") {
  for (const int substeps : {1, 4, 10}) {
    World world(weightless());
    FixedTargets targets;
    world.set_target_source(&targets);
    BodyDef def = box_def(1.0, Vec3(0.2, 0.3, 0.4), Vec3(1.0, 2.0, 3.0));
    def.locks = {.linear = {true, false, false}, .angular = {true, true, false}};
    const BodyId body = world.add_body(def);
    targets.targets.push_back({.body = body,
                               .pose = {Vec3(1.5, 2.5, 3.5), turn(Vec3(0.3, 0.2, 0.4))},
                               .twist = {Vec3(0.1, 0.0, 0.0), Vec3(0.2, 0.0, 0.0)},
                               .share = 0.3});
    Solver solver({.substeps = substeps, .sleep_after = 0.0});
    run(world, solver, 1.0, [&] {
      REQUIRE(world.pose(body).position.x() == 1.0);
      REQUIRE(world.twist(body).linear.x() == 0.0);
    });
    CHECK(world.pose(body).position.y() == Approx(2.5).epsilon(1e-3));
    // It has turned, about z alone.
    const Vec3 axis = world.pose(body).orientation * Vec3::UnitZ();
    CHECK((axis - Vec3::UnitZ()).norm() < 1e-12);
    CHECK(angle_between(world.pose(body).orientation, Quat::Identity()) > 0.1);
  }
}

}  // namespace locks_test
