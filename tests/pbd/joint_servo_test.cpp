// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "joint_law.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

/// Motors with a stiffness or damping: springs and dampers whose force has a bound.
namespace joint_servo_test {

using namespace tandem::pbd;
using namespace tandem::testing;

/// A servo to 0, by its definition.
struct Servo {
  double stiffness, damping, max_force;
  double force(double x, double v) const {
    return std::clamp(-stiffness * x - damping * v, -max_force, max_force);
  }
  /// N m or N, whatever the sign: what it stores.
  double energy(double x) const {
    const double reach = std::min(std::abs(x), max_force / stiffness);
    return 0.5 * stiffness * reach * reach + max_force * (std::abs(x) - reach);
  }
  JointMotor motor() const {
    return {.mode = MotorMode::Position,
            .max_force = max_force,
            .stiffness = stiffness,
            .damping = damping};
  }
};

/// A box of `mass` on a way along x, `x` from where its servo wants it.
struct Cart : Mounted {
  SliderJointDef def;
  Cart(double mass, double x, const JointMotor& motor, const SolverOptions& options)
      : Mounted(weightless(), options) {
    add_box(mass, Vec3::Zero());
    def = slider_joint_at(world, {}, body, Vec3::Zero(), Vec3::UnitX());
    def.axis.motor = motor;
    def.axis.motor.target = -x;
    add_joint(def);
  }
  double speed() const { return world.twist(body).linear.x(); }
};

TEST_CASE("joint servo: the force is min(k x, F) at any substep", "[pbd][joint][servo][analytic]") {
  const double mass = GENERATE(0.1, 40.0);
  const int substeps = GENERATE(1, 4, 32);
  const double stiffness = GENERATE(3.0, 1e3, 1e6);
  const double damping = GENERATE(0.0, 2.0);
  INFO("mass " << mass << ", " << substeps << " substeps, " << stiffness << " N/m");
  const Servo servo{stiffness, damping * mass, 2.0 * mass};
  const double start = 1.0;
  Cart cart(mass, start, servo.motor(),
            {.substeps = substeps, .refine = false, .sleep_after = 0.0});
  const double h = kFrame / substeps;
  double x = start;
  double v = 0.0;
  const double energy = servo.energy(start);
  double worst = 0.0;
  cart.run(4.0, [&] {
    for (int i = 0; i < substeps; ++i) {
      // v' = v + h F(x + h v', v') / m, of which F is a clamped straight line.
      const double inside =
          (v - h * stiffness * x / mass) / (1.0 + h * (h * stiffness + servo.damping) / mass);
      const double bound = h * servo.max_force / mass;
      v = std::clamp(inside, v - bound, v + bound);
      x += h * v;
    }
    worst = std::max(worst, std::abs(cart.state().position[0] + start - x));
    CHECK(std::abs(cart.state().load[0]) <= servo.max_force * (1.0 + 1e-9));
    CHECK(0.5 * mass * cart.speed() * cart.speed() + servo.energy(x) <= energy * (1.0 + 1e-9));
  });
  CHECK(worst < 1e-9);
}

TEST_CASE("joint servo: a load within its bound sags m g / k, a larger one falls",
          "[pbd][joint][servo][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3::Zero());
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = Servo{400.0, 60.0, 25.0}.motor();
  m.add_joint(def);
  m.run(4.0);
  CHECK(m.state().position[0] == Approx(-2.0 * kGravity / 400.0).epsilon(1e-6));
  CHECK(m.state().load[0] == Approx(2.0 * kGravity).epsilon(1e-6));
  def.axis.motor.max_force = 15.0;
  m.joints->set(m.world, m.joint, def);
  m.run(1.0);
  CHECK(m.world.twist(m.body).linear.z() == Approx(15.0 / 2.0 - kGravity).epsilon(1e-6));
}

TEST_CASE("joint servo: to a speed, with a spring, a damper and dry friction beside it",
          "[pbd][joint][servo][analytic]") {
  const SolverOptions fine{.substeps = 32, .refine = false, .sleep_after = 0.0};
  const JointMotor to_speed{
      .mode = MotorMode::Velocity, .target = 3.0, .max_force = 10.0, .damping = 5.0};
  Cart cart(2.0, 0.0, to_speed, fine);
  cart.def.axis.motor = to_speed;
  cart.joints->set(cart.world, cart.joint, cart.def);
  cart.run(0.2);  // at its bound until it is 2 m/s below
  CHECK(cart.speed() == Approx(1.0).epsilon(1e-6));
  cart.run(0.4);
  CHECK(cart.speed() == Approx(3.0 - 2.0 * std::exp(-5.0 / 2.0 * 0.4)).epsilon(5e-3));
  // Against friction of 5 N and a damper of 2 N s/m: 5 (3 - v) = 5 + 2 v.
  cart.def.axis.friction = 5.0;
  cart.def.axis.spring = {.damping = 2.0};
  cart.joints->set(cart.world, cart.joint, cart.def);
  cart.run(6.0);
  CHECK(cart.speed() == Approx(10.0 / 7.0).epsilon(1e-6));
  // At its bound: 10 = 5 + 2 v.
  cart.def.axis.motor.target = 30.0;
  cart.joints->set(cart.world, cart.joint, cart.def);
  cart.run(8.0);
  CHECK(cart.speed() == Approx(2.5).epsilon(1e-3));
  // A spring of 50 N/m stops it.
  cart.def.axis.friction = 0.0;
  cart.def.axis.spring = {
      .stiffness = 50.0, .rest = cart.state().position[0] + 0.05, .damping = 30.0};
  cart.joints->set(cart.world, cart.joint, cart.def);
  cart.run(8.0);
  CHECK(cart.state().position[0] - cart.def.axis.spring.rest == Approx(0.2).epsilon(1e-6));
}

/// The graph of a law by its definition.
double force_at(const JointAxis& axis, double c, double c_start, double h) {
  const auto spring = [&](double k, double rest, double d) {
    return -h * h * k * (c - rest) - h * d * (c - c_start);
  };
  const JointMotor& motor = axis.motor;
  double sum = spring(axis.spring.stiffness, axis.spring.rest, axis.spring.damping);
  const double most = h * h * motor.max_force;
  const bool to_speed = motor.mode == MotorMode::Velocity;
  const double servo = to_speed ? h * motor.damping * (c_start + h * motor.target - c)
                                : spring(motor.stiffness, motor.target, motor.damping);
  sum += std::clamp(servo, -most, most);
  const double beyond = std::min(c - axis.lower, 0.0) + std::max(c - axis.upper, 0.0);
  if (beyond != 0.0) sum -= (h * h / axis.compliance) * beyond + h * axis.damping * (c - c_start);
  return sum - std::copysign(h * h * axis.friction, c - c_start);
}

TEST_CASE("joint servo: the law of a row is the sum of its parts, wherever their corners are",
          "[pbd][joint][servo][random]") {
  SplitMix64 random(11);
  for (int draw = 0; draw < 4000; ++draw) {
    CAPTURE(draw);
    const double h = 1.0 / 240.0;
    JointAxis axis;
    axis.freedom = random.below(2) == 0 ? Freedom::Limited : Freedom::Free;
    axis.lower = axis.freedom == Freedom::Limited ? random.uniform(-1.0, 0.2) : -kUnlimited;
    axis.upper =
        axis.freedom == Freedom::Limited ? axis.lower + random.uniform(0.0, 1.0) : kUnlimited;
    if (axis.freedom == Freedom::Limited) axis.compliance = random.uniform(1e-4, 1e-2);
    if (random.below(2) == 0) axis.spring.stiffness = random.uniform(0.0, 500.0);
    if (random.below(2) == 0) axis.spring.damping = random.uniform(0.0, 50.0);
    axis.spring.rest = random.uniform(-1.0, 1.0);
    if (random.below(2) == 0) axis.friction = random.uniform(0.0, 50.0);
    axis.motor.mode = random.below(2) == 0 ? MotorMode::Position : MotorMode::Velocity;
    axis.motor.target = random.uniform(-1.0, 1.0);
    axis.motor.max_force = random.uniform(1.0, 100.0);
    axis.motor.damping = random.uniform(0.1, 50.0);
    if (axis.motor.mode == MotorMode::Position) axis.motor.stiffness = random.uniform(1.0, 500.0);
    const double c_start = std::clamp(random.uniform(-1.0, 1.0), axis.lower, axis.upper);
    const double c = c_start + random.uniform(-0.1, 0.1);
    const double w = random.uniform(0.1, 3.0);
    const double lambda = force_law(axis, c_start, 0.0, h).multiplier(c, 0.0, w);
    // The distance of c + w lambda to the graph grows with lambda: it changes its sign here.
    const double step = 1e-9;
    const double low = lambda - step;
    const double high = lambda + step;
    CHECK(low <= force_at(axis, c + w * low, c_start, h));
    CHECK(high >= force_at(axis, c + w * high, c_start, h));
  }
}

TEST_CASE("joint servo: arms of bounded servos gain no energy", "[pbd][joint][servo][energy]") {
  SplitMix64 random(4);
  for (int draw = 0; draw < 12; ++draw) {
    CAPTURE(draw);
    World world(weightless());
    auto& joints = world.add_block<JointBlock>();
    BodyId before;
    std::vector<JointId> ids;
    std::vector<Servo> servos;
    for (int i = 0; i < 4; ++i) {
      const double mass = random.uniform(0.3, 3.0);
      const BodyId body =
          world.add_body(box_def(mass, Vec3(0.15, 0.05, 0.05), Vec3(0.15 + 0.3 * i, 0.0, 0.0)));
      HingeJointDef def = hinge_joint_at(world, before, body, Vec3(0.3 * i, 0.0, 0.0),
                                         i % 2 == 0 ? Vec3::UnitZ() : Vec3::UnitY());
      const double stiffness = std::exp(random.uniform(0.0, 9.0));
      servos.push_back({stiffness, 0.0, random.uniform(0.2, 5.0)});
      def.axis.motor = servos.back().motor();
      def.axis.motor.target = random.uniform(-2.0, 2.0);
      ids.push_back(joints.add(world, def));
      before = body;
    }
    const auto energy = [&] {
      double sum = world.kinetic_energy();
      for (std::size_t i = 0; i < ids.size(); ++i) {
        sum += servos[i].energy(joints.hinge_angle(ids[i]) -
                                joints.def(ids[i]).angular[0].motor.target);
      }
      return sum;
    };
    Solver solver({.sleep_after = 0.0});
    const double start = energy();
    double most = 0.0;
    run(world, solver, 5.0, [&] { most = std::max(most, energy()); });
    CHECK(most <= start * (1.0 + 1e-3));
  }
}

TEST_CASE("joint servo: invalid servos are refused, and snapshots keep valid ones",
          "[pbd][joint][servo][errors]") {
  Cart cart(1.0, 0.5, Servo{40.0, 1.0, 3.0}.motor(), {.sleep_after = 0.0});
  const auto refused = [&](auto&& change) {
    SliderJointDef bad = cart.def;
    change(bad.axis.motor);
    return refusal([&] { cart.joints->add(cart.world, bad); });
  };
  CHECK(names(refused([](JointMotor& m) { m.stiffness = -1.0; }), "linear[0].motor.stiffness", "-1",
              "finite and >= 0"));
  CHECK(names(refused([](JointMotor& m) { m.damping = kUnlimited; }), "linear[0].motor.damping",
              "inf", "finite and >= 0"));
  CHECK(names(refused([](JointMotor& m) { m.mode = MotorMode::Velocity; }),
              "linear[0].motor.stiffness", "40", "0 of a servo to a speed"));
  CHECK(names(refused([](JointMotor& m) { m.stiffness = 0.0; }), "linear[0].motor.stiffness", "0",
              "> 0 of a servo to a position"));
  CHECK(names(refused([](JointMotor& m) { m.max_speed = 2.0; }), "linear[0].motor.max_speed", "2",
              "infinite of a servo"));
  cart.run(0.3);
  const std::vector<std::byte> bytes = cart.world.snapshot();
  cart.run(0.5);
  const std::uint64_t hash = cart.world.hash();
  cart.world.restore(bytes);
  cart.run(0.5);
  CHECK(cart.world.hash() == hash);
}

TEST_CASE("joint servo: a held body may sleep", "[pbd][joint][servo][sleep]") {
  Mounted m(WorldDef{}, {});
  m.add_box(2.0, Vec3::Zero());
  SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = Servo{400.0, 60.0, 50.0}.motor();
  m.add_joint(def);
  m.run(4.0);
  CHECK_FALSE(m.world.awake(m.body));
}

}  // namespace joint_servo_test
