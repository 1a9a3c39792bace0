// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "support/catch.h"

/// Springs by frequency and damping ratio, against the closed form.
namespace joint_spring_test {

using namespace tandem::pbd;
using namespace tandem::testing;

/// P and Q in x(t + h) - P x(t) + Q x(t - h) = 0, which all x(t) = exp(-zeta w t) (A cos(w_d t) + B
/// sin(w_d t)) obey, and the two decays of zeta > 1.
struct Recurrence {
  double p, q;
  Recurrence(double frequency, double zeta, double h) {
    const double turn = 2.0 * kPi * frequency * h;
    q = std::exp(-2.0 * zeta * turn);
    p = zeta < 1.0 ? 2.0 * std::exp(-zeta * turn) * std::cos(turn * std::sqrt(1.0 - zeta * zeta))
                   : 2.0 * std::exp(-zeta * turn) * std::cosh(turn * std::sqrt(zeta * zeta - 1.0));
  }
};

TEST_CASE("joint spring: a mass goes through the points of the closed form at any step and mass",
          "[pbd][joint][spring][analytic]") {
  const double mass = GENERATE(0.01, 1.0, 300.0);
  const double zeta = GENERATE(0.0, 0.1, 0.7, 1.0, 3.0);
  const int substeps = GENERATE(1, 4, 13);
  const double dt = GENERATE(1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0);  // 0.36 rad at most
  INFO("mass " << mass << ", ratio " << zeta << ", " << substeps << " substeps, dt " << dt);
  const double frequency = 1.7;
  Mounted m(weightless(), {.substeps = substeps, .refine = false, .sleep_after = 0.0});
  m.add_box(mass, Vec3(0.3, 0.0, 0.0));
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
  def.axis.spring = {.rest = 0.2, .frequency = frequency, .damping_ratio = zeta};
  m.add_joint(def);
  m.world.set_twist(m.body, {Vec3(1.0, 0.0, 0.0), Vec3::Zero()});
  std::vector<double> x;
  for (int i = 0; i < 60; ++i) {
    m.solver.step(m.world, dt);
    x.push_back(m.state().position[0] - 0.2);
  }
  const Recurrence exact(frequency, zeta, dt);
  double worst = 0.0;
  for (std::size_t i = 2; i < x.size(); ++i) {
    worst = std::max(worst, std::abs(x[i] - exact.p * x[i - 1] + exact.q * x[i - 2]));
  }
  CHECK(worst < 1e-12);
}

TEST_CASE(
    "joint spring: two bodies swing with their reduced mass, a door with the inertia about "
    "its hinge",
    "[pbd][joint][spring][analytic]") {
  SECTION("two bodies") {
    World world(weightless());
    auto& joints = world.add_block<JointBlock>();
    const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
    const BodyId b = world.add_body(box_def(50.0, kHalf, Vec3(1.0, 0.0, 0.0)));
    SliderJointDef def = slider_joint_at(world, a, b, Vec3::Zero(), Vec3::UnitX());
    def.axis.spring = {.rest = 0.1, .frequency = 3.0, .damping_ratio = 0.05};
    const JointId id = joints.add(world, def);
    Solver solver({.sleep_after = 0.0});
    std::vector<double> x;
    run(world, solver, 2.0, [&] { x.push_back(joints.at(id).position[0] - 0.1); });
    const Recurrence exact(3.0, 0.05, kFrame);
    for (std::size_t i = 2; i < x.size(); ++i) {
      CHECK(std::abs(x[i] - exact.p * x[i - 1] + exact.q * x[i - 2]) < 1e-12);
    }
  }
  SECTION("a door") {
    Mounted m;
    m.add_box(20.0, Vec3(0.4, 0.0, 0.0));
    HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
    def.axis.spring = {.rest = 0.5, .frequency = 0.8, .damping_ratio = 0.2};
    m.add_joint(def);
    std::vector<double> x;
    m.run(3.0, [&] { x.push_back(m.state().position[3] - 0.5); });
    const Recurrence exact(0.8, 0.2, kFrame);
    for (std::size_t i = 2; i < x.size(); ++i) {
      CHECK(std::abs(x[i] - exact.p * x[i - 1] + exact.q * x[i - 2]) < 1e-5);
    }
  }
}

TEST_CASE("joint spring: a load stretches it by m g over the stiffness of its frequency",
          "[pbd][joint][spring][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(5.0, Vec3::Zero());
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.spring = {.frequency = 2.0, .damping_ratio = 1.0};
  m.add_joint(def);
  m.run(8.0);
  const double rate = 2.0 * kPi * 2.0;
  CHECK(m.state().position[0] == Approx(-kGravity / (rate * rate)).epsilon(1e-3));
  CHECK(m.state().load[0] == Approx(5.0 * kGravity).epsilon(1e-9));
}

TEST_CASE("joint spring: any number of springs on one body keep its energy",
          "[pbd][joint][spring][energy]") {
  const double turn = GENERATE(0.05, 0.2, 0.5, 0.8, 1.0, 10.0, 1e4);  // rad in a substep
  const int count = GENERATE(1, 12);
  INFO("turn " << turn << " rad, " << count << " springs");
  Mounted m(weightless(), {.substeps = 1, .refine = false, .sleep_after = 0.0});
  m.add_box(2.0, Vec3::Zero());
  for (int i = 0; i < count; ++i) {
    SixDofJointDef def = six_dof_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
    for (JointAxis& axis : def.linear) axis.spring = {.frequency = turn / (2.0 * kPi * kFrame)};
    m.add_joint(def);
  }
  m.world.set_twist(m.body, {Vec3(1.0, -0.5, 0.3), Vec3::Zero()});
  // A velocity is that of half a substep before: each spring has what it stored on the way.
  const double stored = turn <= 0.5 ? std::pow(std::tan(0.5 * turn), 2.0) : 0.07;
  const double energy = m.world.kinetic_energy() * (1.0 + count * stored);
  double most = 0.0;
  m.run(20.0, [&] { most = std::max(most, m.world.kinetic_energy()); });
  CHECK(most < energy * (1.0 + 1e-6));
  if (turn >= 1.0) CHECK(m.world.kinetic_energy() < 1e-6 * energy);
}

TEST_CASE("joint spring: snapshots keep the masses behind its stiffness", "[pbd][joint][spring]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3(0.3, 0.1, 0.0));
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitY());
  def.axis.spring = {.frequency = 2.0, .damping_ratio = 0.1};
  m.add_joint(def);
  m.run(0.5);
  const std::vector<std::byte> bytes = m.world.snapshot();
  m.run(0.5);
  const std::uint64_t hash = m.world.hash();
  m.world.restore(bytes);
  m.run(0.5);
  CHECK(m.world.hash() == hash);
}

TEST_CASE("joint friction: a hinge stops after I w / M and holds smaller torques",
          "[pbd][joint][friction][analytic]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.friction = 0.05;
  m.add_joint(def);
  const double inertia = m.world.props(m.body).inertia(2, 2);
  const double start = 0.05 / inertia;  // so that it takes a second
  m.world.set_twist(m.body, {Vec3::Zero(), start * Vec3::UnitZ()});
  m.run(0.5);
  CHECK(m.world.twist(m.body).angular.z() == Approx(0.5 * start).epsilon(1e-6));
  CHECK(m.state().load[3] == Approx(-0.05).epsilon(1e-6));
  m.run(1.0);
  CHECK(m.state().position[3] == Approx(0.5 * start).epsilon(2e-3));
  for (const double torque : {0.049, 0.06}) {
    m.world.set_twist(m.body, {});
    m.run(0.5, [&] { m.world.apply_torque(m.body, torque * Vec3::UnitZ()); });
    const double left = torque > 0.05 ? (torque - 0.05) / inertia * (0.5 - kFrame) : 0.0;
    CHECK(m.world.twist(m.body).angular.z() == Approx(left).margin(1e-6).epsilon(1e-3));
  }
}

TEST_CASE("joint friction: a motor that is on takes its place", "[pbd][joint][friction]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.friction = 100.0;
  def.axis.motor = {.mode = MotorMode::Velocity, .target = 2.0, .max_force = 1.0};
  m.add_joint(def);
  m.run(2.0);
  CHECK(m.world.twist(m.body).angular.z() == Approx(2.0).epsilon(1e-9));
  def.axis.motor.mode = MotorMode::Off;
  m.joints->set(m.world, m.joint, def);
  m.run(0.1);
  CHECK(m.world.twist(m.body).angular.norm() < 1e-9);
}

TEST_CASE("joint: a definition without effect is refused", "[pbd][joint]") {
  Mounted m;
  m.add_box(1.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  const auto refused = [&](auto&& change) {
    HingeJointDef bad = def;
    change(bad.axis);
    return refusal([&] { m.joints->add(m.world, bad); });
  };
  CHECK(names(refused([](JointAxis& a) { a.damping = 0.5; }), "angular[0].damping", "0.5",
              "0 on a free axis"));
  CHECK(names(refused([](JointAxis& a) { a.compliance = 0.5; }), "angular[0].compliance", "0.5",
              "0 on a free axis"));
  CHECK(names(refused([](JointAxis& a) { a.friction = -1.0; }), "angular[0].friction", "-1",
              "finite and >= 0"));
  CHECK(names(refused([](JointAxis& a) { a.spring.frequency = -1.0; }),
              "angular[0].spring.frequency", "-1", "finite and >= 0"));
  CHECK(names(refused([](JointAxis& a) { a.spring = {.stiffness = 3.0, .frequency = 1.0}; }),
              "angular[0].spring.stiffness", "3", "0 where there is a frequency"));
  CHECK(names(refused([](JointAxis& a) { a.spring = {.damping = 3.0, .frequency = 1.0}; }),
              "angular[0].spring.damping", "3", "0 where there is a frequency"));
  CHECK(names(refused([](JointAxis& a) { a.spring.damping_ratio = 0.7; }),
              "angular[0].spring.damping_ratio", "0.7", "0 without a frequency"));
  SixDofJointDef fixed = fixed_joint_at(m.world, {}, m.body, Vec3::Zero());
  fixed.linear[1].friction = 2.0;
  CHECK(names(refusal([&] { m.joints->add(m.world, fixed); }), "linear[1].friction", "2",
              "0 on a locked axis"));
  CHECK(m.joints->size() == 0);
}

}  // namespace joint_spring_test
