// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

/// Motors, springs and friction of ball joints.
namespace ball_drive_test {

using namespace tandem::pbd;
using namespace tandem::testing;

constexpr double kMass = 2.0;    // kg
constexpr double kRadius = 0.3;  // m
constexpr double kInertia = 0.4 * kMass * kRadius * kRadius;

/// A ball about its middle, or a box.
struct Driven : Mounted {
  BallJointDef def;

  explicit Driven(bool box = false, const WorldDef& world_def = weightless(),
                  const Vec3& middle = Vec3::Zero(),
                  const SolverOptions& options = {.substeps = 4, .sleep_after = 0.0})
      : Mounted(world_def, options) {
    body = world.add_body(box ? box_def(kMass, kHalf, middle) : ball_def(kMass, kRadius, middle));
    def = ball_joint_at(world, {}, body, Vec3::Zero(), Vec3(1.0, 2.0, 0.5).normalized());
  }
  void start(const BallDrive& drive) {
    def.drive = drive;
    add_joint(def);
  }
  Quat turn() const {
    return (def.frame_a.basis.conjugate() * world.pose(body).orientation * def.frame_b.basis)
        .normalized();
  }
  Vec3 to_a(const Vec3& w) const { return def.frame_a.basis.conjugate() * w; }
};

TEST_CASE("ball drive: a motor reaches its rate with at most its torque, through all angles",
          "[pbd][joint][drive][analytic]") {
  Driven m;
  const Vec3 rate(1.0, 2.0, -3.0);
  const double torque = 0.1;
  m.start({.motor = {.mode = MotorMode::Velocity, .velocity = rate, .max_torque = torque}});
  double most = 0.0;
  m.run(0.5, [&] { most = std::max(most, m.to_a(m.state().torque).cwiseAbs().maxCoeff()); });
  const double gained = torque / kInertia * 0.5;
  const Vec3 half = m.to_a(m.world.twist(m.body).angular);
  for (int i = 0; i < 3; ++i) {
    INFO("axis " << i);
    CHECK(std::abs(half[i]) == Approx(std::min(gained, std::abs(rate[i]))).epsilon(1e-6));
  }
  m.run(10.0, [&] { most = std::max(most, m.to_a(m.state().torque).cwiseAbs().maxCoeff()); });
  CHECK((m.to_a(m.world.twist(m.body).angular) - rate).norm() < 1e-9);
  CHECK(most <= torque * (1.0 + 1e-9));
  CHECK(m.state().torque.norm() < 1e-6);
}

TEST_CASE("ball drive: two bodies that a motor turns keep their momentum",
          "[pbd][joint][drive][momentum]") {
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  const BodyId a = world.add_body(ball_def(1.0, 0.2, Vec3::Zero()));
  const BodyId b = world.add_body(ball_def(3.0, 0.3, Vec3::Zero()));
  BallJointDef def = ball_joint_at(world, a, b, Vec3::Zero());
  const Vec3 rate(0.5, 1.0, -0.7);
  def.drive.motor = {.mode = MotorMode::Velocity, .velocity = rate, .max_torque = 1.0};
  joints.add(world, def);
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 3.0);
  const Vec3 w_a = world.twist(a).angular;
  const Vec3 w_b = world.twist(b).angular;
  const Quat axes = world.pose(a).orientation * def.frame_a.basis;
  const Vec3 relative = axes.conjugate() * Vec3(w_b - w_a);
  CHECK((relative - rate).norm() < 1e-3);  // frame a turns within a substep
  const Vec3 momentum = world.props(a).inertia(0, 0) * w_a + world.props(b).inertia(0, 0) * w_b;
  CHECK(momentum.norm() < 1e-9);
}

TEST_CASE("ball drive: a motor goes to its target the shorter way, at its speed",
          "[pbd][joint][drive][analytic]") {
  Driven m;
  const Quat target = exp_map(Vec3(0.5, -2.0, 1.0));
  m.start({.motor = {.mode = MotorMode::Position, .target = target, .max_speed = 1.0}});
  const double way = Vec3(0.5, -2.0, 1.0).norm();
  m.run(1.0);
  CHECK(rotation_between(m.turn(), target).norm() == Approx(way - 1.0).margin(1e-6));
  m.run(2.0);
  CHECK(rotation_between(m.turn(), target).norm() < 1e-9);
  CHECK(m.world.twist(m.body).angular.norm() < 1e-9);
}

TEST_CASE("ball drive: a motor holds a load, and not more than its torque",
          "[pbd][joint][drive][analytic]") {
  for (const bool strong : {true, false}) {
    Driven m(false, WorldDef{}, Vec3(0.5, 0.0, 0.0));
    const double load = kMass * kGravity * 0.5;
    m.start(
        {.motor = {.mode = MotorMode::Position, .max_torque = strong ? 2.0 * load : 0.3 * load}});
    m.run(2.0);
    INFO("strong " << strong);
    CHECK((rotation_between(m.turn(), Quat::Identity()).norm() < 1e-6) == strong);
    if (strong) CHECK(m.state().torque.norm() == Approx(load).epsilon(1e-6));
    CHECK(m.to_a(m.state().torque).cwiseAbs().maxCoeff() <= 2.0 * load);
  }
}

TEST_CASE("ball drive: a spring goes through the points of the closed form about any axis",
          "[pbd][joint][drive][spring][analytic]") {
  const double zeta = GENERATE(0.0, 0.2, 1.5);
  const int substeps = GENERATE(1, 5);
  const double frequency = 1.3;
  Driven m(false, weightless(), Vec3::Zero(),
           {.substeps = substeps, .refine = false, .sleep_after = 0.0});
  const Vec3 away(1.2, -0.9, 0.4);
  m.start({.spring = {.frequency = frequency, .damping_ratio = zeta, .rest = exp_map(away)}});
  std::vector<double> x;
  m.run(2.0,
        [&] { x.push_back(rotation_between(exp_map(away), m.turn()).dot(away.normalized())); });
  const double turn = 2.0 * kPi * frequency * kFrame;
  const double root = std::sqrt(std::abs(1.0 - zeta * zeta));
  const double p =
      2.0 * std::exp(-zeta * turn) * (zeta < 1.0 ? std::cos(turn * root) : std::cosh(turn * root));
  const double q = std::exp(-2.0 * zeta * turn);
  double worst = 0.0;
  for (std::size_t i = 2; i < x.size(); ++i)
    worst = std::max(worst, std::abs(x[i] - p * x[i - 1] + q * x[i - 2]));
  INFO("ratio " << zeta << ", " << substeps << " substeps");
  CHECK(worst < 1e-9);
}

TEST_CASE("ball drive: springs and friction give a tumbling box no energy",
          "[pbd][joint][drive][energy]") {
  const double stiffness = GENERATE(0.0, 2.0);
  const double friction = GENERATE(0.0, 0.02);
  Driven m(true);
  m.start({.spring = {.stiffness = stiffness}, .friction = friction});
  m.world.set_twist(m.body, {Vec3::Zero(), Vec3(3.0, -2.0, 4.0)});
  const auto energy = [&] {
    const double angle = rotation_between(Quat::Identity(), m.turn()).norm();
    return m.world.kinetic_energy() + 0.5 * stiffness * angle * angle;
  };
  const double first = energy();
  double most = 0.0;
  m.run(10.0, [&] { most = std::max(most, energy()); });
  INFO("stiffness " << stiffness << ", friction " << friction);
  CHECK(most < first * 1.001);
  if (friction > 0.0 && stiffness == 0.0) CHECK(m.world.kinetic_energy() < 1e-9);
}

// Torques about three axes of different stiffness had no energy of their own, at any length of the
// step: turns of 0.5, 1, 1.5 and 2 rad came to 1.2, 4.8, 2.1 and 5.6 times what there was at first.
TEST_CASE("ball drive: an undamped spring of a frequency has an energy, about axes that differ",
          "[pbd][joint][drive][spring][energy]") {
  constexpr double kFrequency = 1.0;                 // Hz
  const double turn = GENERATE(0.5, 1.0, 1.5, 2.0);  // rad, about how far it goes
  Driven m;
  m.body = m.world.add_body(box_def(kMass, Vec3(0.3, 0.1, 0.05), Vec3::Zero()));
  m.def = ball_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3(1.0, 2.0, 0.5).normalized());
  m.start({.spring = {.frequency = kFrequency}});
  m.world.set_twist(
      m.body, {Vec3::Zero(), 2.0 * kPi * kFrequency * turn * Vec3(0.5, -0.7, 0.6).normalized()});
  const double first = m.world.kinetic_energy();  // it starts at rest, where the spring has none
  double most = 0.0;
  double late = 0.0;
  m.run(20.0, [&] {
    most = std::max(most, m.world.kinetic_energy());
    if (m.world.time() > 15.0) late = std::max(late, m.world.kinetic_energy());
  });
  INFO("turn " << turn);
  CHECK(most < first * 1.001);
  CHECK(late > 0.6 * first);  // nor is it damped
}

TEST_CASE("ball drive: friction takes M / I of each rate", "[pbd][joint][drive][analytic]") {
  Driven m;
  m.start({.friction = 0.05});
  const Vec3 rate(1.0, -2.0, 0.4);
  m.world.set_twist(m.body, {Vec3::Zero(), m.def.frame_a.basis * rate});
  m.run(0.5);
  const double lost = 0.05 / kInertia * 0.5;
  const Vec3 left = m.to_a(m.world.twist(m.body).angular);
  for (int i = 0; i < 3; ++i) {
    CHECK(std::abs(left[i]) == Approx(std::max(0.0, std::abs(rate[i]) - lost)).margin(1e-6));
  }
}

TEST_CASE("ball drive: cone and twist limits are stronger", "[pbd][joint][drive][fault]") {
  Driven m;
  m.def.cone = 0.5;
  m.def.limit_twist = true;
  m.def.lower_twist = -0.2;
  m.def.upper_twist = 0.2;
  m.start({.motor = {
               .mode = MotorMode::Velocity, .velocity = Vec3(2.0, 1.0, -3.0), .max_torque = 1.0}});
  double swing = 0.0;
  double twist = 0.0;
  m.run(5.0, [&] {
    swing = std::max(swing, m.state().swing);
    twist = std::max(twist, m.state().position[3]);
  });
  CHECK(swing == Approx(0.5).margin(1e-4));
  CHECK(twist == Approx(0.2).margin(1e-4));
  CHECK(m.world.twist(m.body).angular.norm() < 0.05);  // it slides along the cone to where it stays
}

TEST_CASE("ball drive: a running drive keeps its body awake, a holding one lets it sleep",
          "[pbd][joint][drive]") {
  const bool runs = GENERATE(true, false);
  Driven m(false, WorldDef{}, Vec3(0.5, 0.0, 0.0), {});
  BallDrive drive{.motor = {.mode = MotorMode::Position}};
  if (runs) {
    drive.motor = {.mode = MotorMode::Velocity, .velocity = Vec3(1e-4, 0.0, 0.0)};
  }
  m.start(drive);
  m.run(3.0);
  CHECK(m.world.awake(m.body) == runs);
}

TEST_CASE("ball drive: snapshots go on with the same bits", "[pbd][joint][drive]") {
  Driven m(true, WorldDef{}, Vec3(0.2, 0.1, 0.0));
  m.start(
      {.spring = {.frequency = 1.0, .damping_ratio = 0.1},
       .motor = {.mode = MotorMode::Velocity, .velocity = Vec3(1.0, 2.0, 0.0), .max_torque = 0.5}});
  m.run(0.4);
  const std::vector<std::byte> bytes = m.world.snapshot();
  m.run(0.5);
  const std::uint64_t hash = m.world.hash();
  m.world.restore(bytes);
  m.run(0.5);
  CHECK(m.world.hash() == hash);
}

TEST_CASE("ball drive: joints that it cannot turn are refused", "[pbd][joint][drive]") {
  Driven m;
  const auto refused = [&](auto&& change) {
    SixDofJointDef bad = m.def;
    bad.drive.friction = 1.0;
    change(bad);
    return refusal([&] { m.joints->add(m.world, bad); });
  };
  using Def = SixDofJointDef;
  CHECK(names(refused([](Def& d) { d.angular[1].freedom = Freedom::Locked; }), "angular[1].freedom",
              "1", "free or limited where the joint has a drive"));
  CHECK(names(refused([](Def& d) { d.angular[0].friction = 2.0; }), "angular[0].friction", "2",
              "0 where the joint has a drive"));
  CHECK(names(refused([](Def& d) { d.drive.friction = -1.0; }), "drive.friction", "-1", ">= 0"));
  CHECK(names(refused([](Def& d) { d.drive.motor.max_torque = 0.0; }), "drive.motor.max_torque",
              "0", "> 0"));
  CHECK(names(refused([](Def& d) { d.drive.spring = {.stiffness = 2.0, .frequency = 1.0}; }),
              "drive.spring.stiffness", "2", "0 where there is a frequency"));
  CHECK(names(refused([](Def& d) { d.drive.motor.target = Quat(2.0, 0.0, 0.0, 0.0); }),
              "drive.motor.target", "2", "a unit quaternion"));
  CHECK(m.joints->size() == 0);
}

}  // namespace ball_drive_test
