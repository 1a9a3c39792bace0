// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <numbers>
#include <string>

#include "joint_fixture.h"
#include "support/catch.h"

/// Inertia of coordinates: rotors behind gears.
namespace joint_armature_test {

using namespace tandem::pbd;
using namespace tandem::testing;

/// Two bars in free space with a hinge about z between them, and a constant torque on it.
struct Pair {
  static constexpr double kTorque = 0.3;  // N m
  World world{weightless()};
  Solver solver{{.substeps = 32, .sleep_after = 0.0}};
  JointBlock& joints = world.add_block<JointBlock>();
  JointId joint;

  /// @param one, two  kg m^2, moments about z
  Pair(double one, double two, double armature) {
    const auto add = [&](double moment) {
      return world.add_body({.mass = 1.0, .inertia = moment * Mat3::Identity()});
    };
    const BodyId a = add(one);
    const BodyId b = add(two);
    HingeJointDef def = hinge_joint_at(world, a, b, Vec3::Zero(), Vec3::UnitZ());
    def.axis.motor = {.mode = MotorMode::Velocity, .target = 1e3, .max_force = kTorque};
    def.axis.armature = armature;
    joint = joints.add(world, def);
  }
};

TEST_CASE("joint armature: a rotor between two bodies adds to the inertia of their joint alone",
          "[pbd][joint][armature][analytic]") {
  const double armature = GENERATE(0.0, 1e-3, 0.1, 10.0);
  CAPTURE(armature);
  const double one = 0.2;
  const double two = 0.05;
  Pair pair(one, two, armature);
  for (int i = 0; i < 60; ++i) pair.solver.step(pair.world, kFrame);
  // q'' = (T - a q'') (1 / I1 + 1 / I2)
  const double mobility = 1.0 / one + 1.0 / two;
  const double rate = Pair::kTorque * mobility / (1.0 + armature * mobility);
  CHECK(pair.joints.hinge_angle(pair.joint) == Approx(0.5 * rate).epsilon(1e-3));
}

TEST_CASE("joint armature: a sled and a top with rotors move as with more inertia",
          "[pbd][joint][armature][analytic]") {
  World world(weightless());
  Solver solver({.substeps = 32, .sleep_after = 0.0});
  JointBlock& joints = world.add_block<JointBlock>();
  const BodyId sled = world.add_body({.mass = 2.0});
  SliderJointDef slider = slider_joint_at(world, {}, sled, Vec3::Zero(), Vec3::UnitX());
  slider.axis.spring.stiffness = 50.0;
  slider.axis.spring.rest = 0.1;
  slider.axis.armature = 3.0;
  const JointId slide = joints.add(world, slider);
  const BodyId top =
      world.add_body({.pose = {.position = {0.0, 3.0, 0.0}}, .inertia = 0.4 * Mat3::Identity()});
  BallJointDef ball = ball_joint_at(world, {}, top, {0.0, 3.0, 0.0});
  ball.drive.armature = 0.6;
  ball.drive.spring.stiffness = 10.0;
  const Quat rest(Eigen::AngleAxisd(0.3, Vec3(0.6, 0.0, 0.8)));
  // The frames of a are those of the world up to their choice of axes.
  ball.drive.spring.rest =
      (ball.frame_a.basis.conjugate() * rest * ball.frame_a.basis).normalized();
  joints.add(world, ball);
  for (int i = 0; i < 60; ++i) {
    solver.step(world, kFrame);
    const double t = (i + 1) * kFrame;
    CHECK(joints.slider_position(slide) ==
          Approx(0.1 * (1.0 - std::cos(std::sqrt(50.0 / 5.0) * t))).margin(1e-3));
    CHECK(world.pose(top).orientation.angularDistance(Quat::Identity()) ==
          Approx(0.3 * (1.0 - std::cos(std::sqrt(10.0 / 1.0) * t))).margin(3e-3));
  }
}

TEST_CASE("joint armature: a spring of a frequency keeps it, with rotors of any size",
          "[pbd][joint][armature][analytic]") {
  const double armature = GENERATE(0.0, 0.1, 10.0);
  CAPTURE(armature);
  World world(weightless());
  Solver solver({.sleep_after = 0.0});
  JointBlock& joints = world.add_block<JointBlock>();
  const BodyId door = world.add_body({.inertia = 0.4 * Mat3::Identity()});
  HingeJointDef def = hinge_joint_at(world, {}, door, Vec3::Zero(), Vec3::UnitZ());
  def.axis.spring = {.rest = 0.2, .frequency = 1.5, .damping_ratio = 0.0};
  def.axis.armature = armature;
  const JointId hinge = joints.add(world, def);
  for (int i = 0; i < 120; ++i) {
    solver.step(world, kFrame);
    const double turned = 2.0 * std::numbers::pi * 1.5 * (i + 1) * kFrame;
    CHECK(joints.hinge_angle(hinge) == Approx(0.2 * (1.0 - std::cos(turned))).margin(4e-3));
  }
}

TEST_CASE("joint armature: a blow on an arm is shared with its rotor",
          "[pbd][joint][armature][analytic]") {
  // The rotor must not take the arm's new speed for nothing, as when a contact turns the arm.
  const double armature = GENERATE(0.001, 0.1, 1.0);
  const double frame = GENERATE(1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0);
  CAPTURE(armature, frame);
  World world(weightless());
  Solver solver({.sleep_after = 0.0});
  JointBlock& joints = world.add_block<JointBlock>();
  const BodyId arm = world.add_body({.inertia = 0.01 * Mat3::Identity()});
  HingeJointDef def = hinge_joint_at(world, {}, arm, Vec3::Zero(), Vec3::UnitZ());
  def.axis.armature = armature;
  joints.add(world, def);
  world.set_twist(arm, {Vec3::Zero(), Vec3(0.0, 0.0, 2.0)});
  solver.step(world, frame);
  const double momentum = (0.01 + armature) * world.twist(arm).angular.z();
  world.apply_angular_impulse(arm, Vec3(0.0, 0.0, -0.03));
  for (int i = 0; i < 30; ++i) solver.step(world, frame);
  CHECK((0.01 + armature) * world.twist(arm).angular.z() ==
        Approx(momentum - 0.03).margin(1e-4 * momentum));
}

TEST_CASE("joint armature: a swinging arm with a rotor at its elbow keeps its energy",
          "[pbd][joint][armature]") {
  const double armature = GENERATE(0.01, 0.5);
  CAPTURE(armature);
  World world;
  Solver solver({.sleep_after = 0.0});
  JointBlock& joints = world.add_block<JointBlock>();
  const auto bar = [&](double x) {
    return world.add_body({.pose = {.position = {x, 0.0, 0.0}},
                           .mass = 1.0,
                           .inertia = Vec3(0.001, 1.0 / 12.0, 1.0 / 12.0).asDiagonal()});
  };
  const BodyId upper = bar(0.5);
  const BodyId lower = bar(1.5);
  joints.add(world, hinge_joint_at(world, {}, upper, Vec3::Zero(), Vec3::UnitY()));
  HingeJointDef elbow = hinge_joint_at(world, upper, lower, Vec3::UnitX(), Vec3::UnitY());
  elbow.axis.armature = armature;
  joints.add(world, elbow);
  double least = kUnlimited;
  double most = -kUnlimited;
  double fastest = 0.0;
  for (int i = 0; i < 2400; ++i) {
    const StepReport& report = solver.step(world, 1.0 / 240.0);
    const double h = 1.0 / 240.0 / report.substeps;
    double energy = world.mechanical_energy();
    // Velocities are those of half a substep before.
    for (const BodyId body : {upper, lower})
      energy += 0.5 * h * world.gravity().dot(world.twist(body).linear);
    const double rate = world.twist(lower).angular.y() - world.twist(upper).angular.y();
    energy += 0.5 * armature * rate * rate;
    least = std::min(least, energy);
    most = std::max(most, energy);
    fastest = std::max(fastest, world.kinetic_energy());
  }
  CHECK(fastest > 10.0);
  CHECK(most - least < 5e-3 * fastest);
}

TEST_CASE("joint armature: it is 0 where there is no coordinate of its own",
          "[pbd][joint][armature][errors]") {
  World world;
  JointBlock& joints = world.add_block<JointBlock>();
  const BodyId body = world.add_body({});
  SixDofJointDef def = hinge_joint_at(world, {}, body, Vec3::Zero(), Vec3::UnitX());
  const auto told = [&] { return refusal([&] { joints.add(world, def); }); };
  CHECK(told().empty());
  def.angular[0].armature = -1.0;
  CHECK(told().find("angular[0].armature must be finite and >= 0") != std::string::npos);
  def.angular[0].armature = 1.0;
  def.angular[1].armature = 1.0;
  CHECK(told().find("angular[1].armature must be 0 on a locked axis") != std::string::npos);
  SixDofJointDef ball = ball_joint_at(world, {}, body, Vec3::Zero());
  ball.drive.armature = 1.0;
  ball.angular[2].armature = 1.0;
  CHECK(refusal([&] { joints.add(world, ball); }).find("0 where the joint has a drive") !=
        std::string::npos);
}

}  // namespace joint_armature_test
