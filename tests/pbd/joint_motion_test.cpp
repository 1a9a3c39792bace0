// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace joint_motion_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// J; velocities are those of half a substep ago, so heights are taken back to there.
double energy_of(const World& world, int substeps) {
  double energy = world.kinetic_energy();
  for (std::size_t i = 0; i < world.states().size(); ++i) {
    const BodyState& state = world.states()[i];
    const Vec3 back = 0.5 * kFrame / substeps * state.twist.linear;
    energy += world.all_props()[i].mass * kGravity * (state.pose.position - back).z();
  }
  return energy;
}

}  // namespace

TEST_CASE("joint motion: a fast heavy top keeps energy, axial and vertical momentum",
          "[pbd][joint][analytic]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  const Quat tilt = turn(Vec3(0.4, 0.0, 0.0));
  const Vec3 up = tilt * Vec3::UnitZ();
  BodyDef def{.pose = {0.3 * up, tilt}, .mass = 1.0};
  def.inertia = Vec3(0.02, 0.02, 0.04).asDiagonal();
  def.twist = {Vec3::Zero(), 20.0 * up};
  const BodyId top = world.add_body(def);
  joints.add(world, ball_joint_at(world, {}, top, Vec3::Zero(), Vec3::UnitZ()));
  Solver solver({.joint_tolerance = 1e-6, .sleep_after = 0.0});
  const double energy = world.mechanical_energy();
  const double axial = 0.04 * 20.0;
  const double vertical = angular_momentum(world).z();
  double energy_error = 0.0;
  double axial_error = 0.0;
  double vertical_error = 0.0;
  for (int i = 0; i < 600; ++i) {
    const int substeps = solver.step(world, kFrame).substeps;
    const Vec3 axis = world.pose(top).orientation * Vec3::UnitZ();
    energy_error = std::max(energy_error, std::abs(energy_of(world, substeps) - energy));
    axial_error =
        std::max(axial_error, std::abs(0.04 * world.twist(top).angular.dot(axis) - axial));
    vertical_error = std::max(vertical_error, std::abs(angular_momentum(world).z() - vertical));
  }
  INFO("energy " << energy_error / energy << ", axial " << axial_error / axial << ", vertical "
                 << vertical_error / vertical);
  CHECK(energy_error < 1e-3 * energy);
  CHECK(axial_error < 1e-9 * axial);
  CHECK(vertical_error < 1e-6 * vertical);
}

TEST_CASE("joint motion: a top keeps its spin about its axis at any rate of steps",
          "[pbd][joint][analytic]") {
  // At the default tolerance: gravity has no moment about the axis of a symmetric body.
  for (const double spin : {5.0, 20.0}) {
    for (const double rate : {30.0, 60.0, 240.0, 480.0}) {
      World world;
      auto& joints = world.add_block<JointBlock>();
      const Quat tilt = turn(Vec3(0.4, 0.0, 0.0));
      const Vec3 up = tilt * Vec3::UnitZ();
      BodyDef def{.pose = {0.3 * up, tilt}, .mass = 1.0};
      def.inertia = Vec3(0.02, 0.02, 0.04).asDiagonal();
      def.twist = {Vec3::Zero(), spin * up};
      const BodyId top = world.add_body(def);
      joints.add(world, ball_joint_at(world, {}, top, Vec3::Zero(), Vec3::UnitZ()));
      Solver solver({.sleep_after = 0.0});
      double error = 0.0;
      for (int i = 0; i < 10.0 * rate; ++i) {
        solver.step(world, 1.0 / rate);
        const Vec3 axis = world.pose(top).orientation * Vec3::UnitZ();
        error = std::max(error, std::abs(world.twist(top).angular.dot(axis) - spin));
      }
      INFO(spin << " rad/s, " << rate << " Hz");
      CHECK(error < 1e-5 * spin);
    }
  }
}

TEST_CASE("joint motion: substeps that come and go take no energy", "[pbd][joint][analytic]") {
  Rope rope(20, 1.0);
  Solver solver({.sleep_after = 0.0});
  const double start = rope.world.mechanical_energy();
  double drift = 0.0;
  int least = 1000;
  int most = 0;
  for (int i = 0; i < 180; ++i) {
    const int substeps = solver.step(rope.world, kFrame).substeps;
    least = std::min(least, substeps);
    most = std::max(most, substeps);
    drift = std::max(drift, std::abs(energy_of(rope.world, substeps) - start));
  }
  INFO(least << " to " << most << " substeps, energy " << drift / rope.swing_energy);
  CHECK(most > least);
  CHECK(drift < 1e-3 * rope.swing_energy);
}

TEST_CASE("joint motion: a body with a locked axis swings on its joint", "[pbd][joint][fault]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  BodyDef def = box_def(1.0, Vec3(0.5, 0.05, 0.1), Vec3(0.5, 0.0, 0.0));
  def.locks.angular = {true, false, true};
  const BodyId rod = world.add_body(def);
  joints.add(world, ball_joint_at(world, {}, rod, Vec3::Zero()));
  Solver solver({.sleep_after = 0.0});
  const double energy = world.mechanical_energy();
  double lowest = 0.0;
  run(world, solver, 2.0, [&] {
    REQUIRE(world.pose(rod).position.allFinite());
    lowest = std::min(lowest, world.pose(rod).position.z());
  });
  CHECK(lowest == Approx(-0.5).margin(1e-3));
  CHECK(std::abs(world.mechanical_energy() - energy) < 0.01 * kGravity);
}

// Its plan has room for rows that it had once; one that is made anew has not.
TEST_CASE("joint motion: motors and joints that were switched on and off leave no trace",
          "[pbd][joint][snapshot]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  std::vector<JointId> ids;
  std::vector<SixDofJointDef> defs;
  BodyId before;
  for (int i = 0; i < 8; ++i) {
    const BodyId link = world.add_body(ball_def(1.0, 0.1, Vec3(0.3 * i, 0.0, 0.0)));
    SixDofJointDef def = hinge_joint_at(world, before, link, Vec3(0.3 * i - 0.15, 0.0, 0.0),
                                        i % 2 == 0 ? Vec3::UnitY() : Vec3::UnitX());
    for (JointAxis& axis : def.angular) {
      if (i % 3 == 2) axis.freedom = Freedom::Free;
    }
    if (i == 4) def.linear[0].freedom = Freedom::Free;
    ids.push_back(joints.add(world, def));
    defs.push_back(def);
    before = link;
  }
  Solver solver({.sleep_after = 0.0});
  SplitMix64 random(11);
  const auto run = [&](int steps, bool calm) {
    for (int k = 0; k < steps; ++k) {
      for (std::size_t i = 0; i < ids.size(); ++i) {
        SixDofJointDef def = defs[i];
        for (JointAxis& axis : def.angular) {
          if (axis.freedom == Freedom::Locked || calm || random.chance(0.5)) continue;
          axis.motor = {.mode = MotorMode::Velocity, .target = 1.0, .max_force = 2.0};
        }
        def.enabled = calm || random.chance(0.9);
        joints.set(world, ids[i], def);
      }
      solver.step(world, kFrame);
    }
  };
  run(40, false);
  run(1, true);
  const auto saved = world.snapshot();
  const SplitMix64 then = random;
  run(30, false);
  const std::uint64_t first = world.hash();
  world.restore(saved);
  random = then;
  run(30, false);
  CHECK(world.hash() == first);
}

}  // namespace joint_motion_test
