// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd::wheel_joint_test {

using tandem::testing::run;

constexpr double kMass = 20.0;                          // kg
constexpr double kStiffness = 5e3;                      // N/m
constexpr double kGravity = 9.81;                       // m/s^2
constexpr double kInertia = 0.8;                        // kg m^2
constexpr double kSag = kMass * kGravity / kStiffness;  // m

/// A wheel that hangs from a chassis that does not move, 1 m above the origin.
struct Axle {
  explicit Axle(const JointAxis& suspension, double brake = 0.0, const JointMotor& drive = {}) {
    chassis = world.add_body({.type = BodyType::Static, .pose = {.position = Vec3(0, 0, 1)}});
    wheel = world.add_body({.pose = {.position = Vec3(0, 0, 1)},
                            .mass = kMass,
                            .inertia = kInertia * Mat3::Identity()});
    WheelJointDef def =
        wheel_joint_at(world, chassis, wheel, Vec3(0, 0, 1), Vec3::UnitY(), Vec3::UnitZ());
    def.suspension = suspension;
    def.brake = brake;
    def.drive = drive;
    joints.add(world, def);
  }
  double height() const { return world.pose(wheel).position.z() - 1.0; }
  double spin() const { return world.twist(wheel).angular.y(); }

  World world;
  JointBlock& joints = world.add_block<JointBlock>();
  Solver solver;
  BodyId chassis;
  BodyId wheel;
};

JointAxis sprung(double damping, double lower) {
  return {.freedom = Freedom::Limited,
          .lower = lower,
          .upper = 0.1,
          .spring = {.stiffness = kStiffness, .damping = damping}};
}

TEST_CASE("wheel joint: hangs as deep as its spring says, or on its stop", "[pbd][joint]") {
  Axle free(sprung(500.0, -0.1));
  run(free.world, free.solver, 3.0);
  CHECK(std::abs(free.height() + kSag) < 1e-5);
  Axle stopped(sprung(500.0, -0.5 * kSag));
  run(stopped.world, stopped.solver, 3.0);
  CHECK(std::abs(stopped.height() + 0.5 * kSag) < 1e-5);
}

TEST_CASE("wheel joint: an undamped spring swings with its period", "[pbd][joint]") {
  Axle axle(sprung(0.0, -0.1));
  // From rest at the spring's own length: twice the sag after half a period, back after a whole
  // one.
  const double period = 2.0 * std::acos(-1.0) * std::sqrt(kMass / kStiffness);
  double lowest = 0.0;
  double when = 0.0;
  for (double t = 1e-3; t < 0.8 * period; t += 1e-3) {
    axle.solver.step(axle.world, 1e-3);
    if (axle.height() < lowest) {
      lowest = axle.height();
      when = t;
    }
  }
  CHECK(std::abs(lowest + 2.0 * kSag) < 0.01 * kSag);
  CHECK(std::abs(when - 0.5 * period) < 0.01 * period);
}

TEST_CASE("wheel joint: a drive turns the axle as its torque says, a brake holds it",
          "[pbd][joint]") {
  Axle driven(sprung(500.0, -0.1), 0.0,
              {.mode = MotorMode::Velocity, .target = 10.0, .max_force = 4.0});
  run(driven.world, driven.solver, 1.0);
  CHECK(std::abs(driven.spin() - 4.0 / kInertia) < 1e-3);  // torque over inertia, for a second
  run(driven.world, driven.solver, 2.0);
  CHECK(std::abs(driven.spin() - 10.0) < 1e-6);
  Axle braked(sprung(500.0, -0.1), 4.0);
  braked.world.set_twist(braked.wheel, {.angular = Vec3(0, 10, 0)});
  run(braked.world, braked.solver, 1.0);
  CHECK(std::abs(braked.spin() - (10.0 - 4.0 / kInertia)) < 1e-3);
  run(braked.world, braked.solver, 2.0);
  CHECK(std::abs(braked.spin()) < 1e-9);
}

}  // namespace tandem::pbd::wheel_joint_test
