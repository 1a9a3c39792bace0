// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstddef>
#include <vector>

#include "joint_fixture.h"
#include "joint_record.h"
#include "support/catch.h"
#include "tandem/pbd/bytes.h"

namespace joint_axis_test {

using namespace tandem::pbd;
using namespace tandem::testing;

TEST_CASE("joint: a velocity motor of limited torque accelerates by torque over inertia",
          "[pbd][joint][analytic]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = {.mode = MotorMode::Velocity, .target = 5.0, .max_force = 0.1};
  m.add_joint(def);
  const double inertia = m.world.props(m.body).inertia(2, 2);
  m.run(1.0);
  CHECK(m.world.twist(m.body).angular.z() == Approx(0.1 / inertia * 1.0).epsilon(1e-6));
  CHECK(m.state().load[3] == Approx(0.1).epsilon(1e-6));
  m.run(5.0);
  CHECK(m.world.twist(m.body).angular.z() == Approx(5.0).epsilon(1e-9));
  CHECK(std::abs(m.state().load[3]) < 1e-6);
}

TEST_CASE("joint: a position motor goes at its speed and stays against a load",
          "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3::Zero());
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = {
      .mode = MotorMode::Position, .target = 0.5, .max_force = 100.0, .max_speed = 1.0};
  m.add_joint(def);
  m.run(0.25);
  // Less the way that it took to reach the speed.
  const double a = 100.0 / 2.0 - kGravity;
  CHECK(m.state().position[0] == Approx(0.25 - 0.5 / a).epsilon(5e-3));
  m.run(1.0);
  CHECK(m.state().position[0] == Approx(0.5).epsilon(1e-9));
  CHECK(m.state().load[0] == Approx(2.0 * kGravity).epsilon(1e-6));
  def.axis.motor.max_force = 10.0;  // less than the weight
  m.joints->set(m.world, m.joint, def);
  m.run(0.5);
  const double g = kGravity - 10.0 / 2.0;
  CHECK(m.state().position[0] == Approx(0.5 - 0.5 * g * 0.5 * (0.5 + kFrame / 10.0)).epsilon(1e-6));
}

TEST_CASE("joint: a motor of unlimited torque does not break a limit, at any angle",
          "[pbd][joint][fault]") {
  for (const double bound : {0.5, kPi - 0.01, kPi, kPi + 0.3, 7.0}) {
    Mounted m;
    m.add_box(2.0, Vec3(0.3, 0.0, 0.0));
    HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
    def.axis = limit(-bound, bound);
    def.axis.motor = {.mode = MotorMode::Velocity, .target = 20.0};
    m.add_joint(def);
    double largest = 0.0;
    m.run(1.0, [&] { largest = std::max(largest, m.state().position[3]); });
    INFO("bound " << bound << " reached " << largest);
    CHECK(largest < bound + 1e-6);
    CHECK(m.state().position[3] == Approx(bound).margin(1e-6));
    def.axis.motor.target = -20.0;
    m.joints->set(m.world, m.joint, def);
    m.run(1.0);
    CHECK(m.state().position[3] == Approx(-bound).margin(1e-6));
    CHECK(m.world.twist(m.body).angular.norm() < 1e-6);
  }
}

TEST_CASE("joint: a rigid limit stops and a sprung one oscillates about statics",
          "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3::Zero());
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis = limit(-0.2, 0.1);
  m.add_joint(def);
  m.run(1.0);
  CHECK(m.state().position[0] == Approx(-0.2).margin(1e-9));
  CHECK(m.state().load[0] == Approx(2.0 * kGravity).epsilon(1e-6));
  def.axis.compliance = 1e-3;
  def.axis.damping = 60.0;
  m.joints->set(m.world, m.joint, def);
  m.run(3.0);
  CHECK(m.state().position[0] == Approx(-0.2 - 2.0 * kGravity * 1e-3).epsilon(1e-6));
}

TEST_CASE("joint: a spring on a hinge swings with its period", "[pbd][joint][analytic]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
  def.axis.spring = {.stiffness = 0.5, .rest = 0.4};
  m.add_joint(def);
  const double inertia = m.world.props(m.body).inertia(0, 0);
  std::vector<double> angles;
  m.run(8.0, [&] { angles.push_back(m.state().position[3] - 0.4); });
  CHECK(mean_period(angles, kFrame) == Approx(2.0 * kPi * std::sqrt(inertia / 0.5)).epsilon(5e-3));
}

TEST_CASE("joint: cone and twist limits hold a tumbling body", "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(1.0, Vec3(0.4, 0.0, 0.0));
  BallJointDef def = ball_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
  def.cone = 0.6;
  def.limit_twist = true;
  def.lower_twist = -0.3;
  def.upper_twist = 0.5;
  m.add_joint(def);
  m.world.set_twist(m.body, {Vec3::Zero(), Vec3(4.0, 2.0, 3.0)});
  const double energy = m.world.mechanical_energy();
  double swing = 0.0;
  double low = 0.0;
  double high = 0.0;
  double gain = 0.0;
  m.run(4.0, [&] {
    swing = std::max(swing, m.state().swing);
    low = std::min(low, m.state().position[3]);
    high = std::max(high, m.state().position[3]);
    gain = std::max(gain, m.world.mechanical_energy() - energy);
  });
  CHECK(swing == Approx(0.6).margin(1e-4));
  CHECK(high == Approx(0.5).margin(1e-4));
  CHECK(low > -0.3 - 1e-4);
  CHECK(gain < 1e-3);
}

TEST_CASE("joint: a soft cone gives way by load times compliance, and its damper stops the swing",
          "[pbd][joint][analytic]") {
  // A bar along x held at its end; gravity has a moment of m g l about y at the edge of the cone.
  const double compliance = 1e-3;
  double swings[2] = {};
  for (const double damping : {0.0, 20.0}) {
    Mounted m(WorldDef{});
    m.add_box(1.0, Vec3(0.4, 0.0, 0.0));
    BallJointDef def = ball_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
    def.cone = 0.3;
    def.angular_compliance = compliance;
    def.angular_damping = damping;
    m.add_joint(def);
    m.run(2.0);
    double low = 10.0;
    double high = 0.0;
    m.run(1.0, [&] {
      low = std::min(low, m.state().swing);
      high = std::max(high, m.state().swing);
    });
    swings[damping > 0.0 ? 1 : 0] = high - low;
    if (damping == 0.0) continue;
    const double load = 1.0 * kGravity * 0.4 * std::cos(m.state().swing);
    CHECK(m.state().swing == Approx(0.3 + load * compliance).epsilon(1e-4));
    CHECK(m.state().torque.norm() == Approx(load).epsilon(1e-3));
  }
  CHECK(swings[0] > 1e-3);
  CHECK(swings[1] < 1e-6);
}

TEST_CASE("joint: bytes with a freedom or mode that no joint has are refused",
          "[pbd][joint][unit]") {
  const auto is_refused = [](auto&& change) {
    JointRecord record;
    change(record.def);
    std::vector<std::byte> bytes;
    ByteWriter out(bytes);
    record.save(out);
    ByteReader in(bytes);
    JointRecord().load(in);
    return in.failed();
  };
  CHECK_FALSE(is_refused([](SixDofJointDef&) {}));
  CHECK(is_refused([](SixDofJointDef& def) { def.linear[2].freedom = Freedom{200}; }));
  CHECK(is_refused([](SixDofJointDef& def) { def.angular[0].freedom = Freedom{3}; }));
  CHECK(is_refused([](SixDofJointDef& def) { def.angular[1].motor.mode = MotorMode{9}; }));
  CHECK(is_refused([](SixDofJointDef& def) { def.drive.motor.mode = MotorMode{9}; }));
}

}  // namespace joint_axis_test
