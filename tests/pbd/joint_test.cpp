// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/joint.h"

#include <functional>
#include <limits>

#include "joint_fixture.h"
#include "support/catch.h"
#include "support/gradient.h"

namespace joint_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

JointAxis lock() { return {.freedom = Freedom::Locked}; }

/// Coordinates of frame b in frame a, written down again: displacement along the axes of a, then
/// twist and swing by taking the rotation apart as swing times twist about x, or about the axis
/// that is free alone.
Eigen::Matrix<double, 7, 1> coordinates_of(const Pose& a, const Pose& b,
                                           const SixDofJointDef& def) {
  Eigen::Matrix<double, 7, 1> c;
  const Quat qa = a.orientation * def.frame_a.basis;
  const Quat qb = b.orientation * def.frame_b.basis;
  c.head<3>() = qa.conjugate() * (b.to_world(def.frame_b.anchor) - a.to_world(def.frame_a.anchor));
  const Quat rel = qa.conjugate() * qb;
  const auto locks = [&](Eigen::Index i) {
    return def.angular[static_cast<std::size_t>(i % 3)].freedom == Freedom::Locked;
  };
  Eigen::Index about = 0;
  for (Eigen::Index i = 1; i < 3; ++i) {
    if (!locks(i) && locks(i + 1) && locks(i + 2)) about = i;
  }
  const Vec3 x = Vec3::Unit(about);
  const Vec3 e = rel * x;
  const double angle = std::acos(std::clamp(e.dot(x), -1.0, 1.0));
  Vec3 axis = x.cross(e);
  if (axis.norm() > 0.0) axis.normalize();
  const Quat swing = turn(angle * axis);
  const Quat twist = swing.conjugate() * rel;
  c.segment<3>(3) = angle * axis;
  c[3 + about] = 2.0 * std::atan(twist.vec()[about] / twist.w());
  c[6] = angle;
  return c;
}

}  // namespace

TEST_CASE("joint: one projection follows the numerical gradient for any locked axes",
          "[pbd][joint][gradient]") {
  // Which coordinates hold: fixed, ball, hinge, slider, universal, planar, and oblique limits.
  for (const std::uint32_t held : {0b111111u, 0b000111u, 0b110111u, 0b111110u, 0b011111u, 0b111100u,
                                   0b000001u, 0b010000u, 0b001000u, 0b100101u, 0b1000000u}) {
    World world;
    const BodyId a = world.add_body({.mass = 1.5, .inertia = box_inertia(1.5, Vec3(.1, .3, .2))});
    const BodyId b = world.add_body({.mass = 0.7, .inertia = box_inertia(0.7, Vec3(.3, .1, .1))});
    world.set_pose(a, {Vec3(0.1, 0.2, 0.3), turn(Vec3(0.5, -0.2, 0.9))});
    world.set_pose(b, {Vec3(0.4, 0.4, -0.2), turn(Vec3(0.1, 0.3, 0.2))});
    SixDofJointDef def{.a = a,
                       .b = b,
                       .frame_a = {Vec3(0.2, 0.1, -0.3), turn(Vec3(0.4, 0.2, 0.3))},
                       .frame_b = {Vec3(-0.1, 0.4, 0.2), turn(Vec3(-0.3, 0.1, 0.6))}};
    for (unsigned i = 0; i < 6; ++i) {
      if ((held >> i & 1u) == 0) continue;
      (i < 3 ? def.linear[i] : def.angular[i - 3]) = lock();
    }
    if (held == 0b1000000u) def.cone = 0.2;
    std::vector<SolverBody> bodies;
    for (const BodyId id : {a, b}) {
      const Mat3 inertia = world.props(id).inertia;
      bodies.push_back(solver_body(world.pose(id), world.props(id).mass, inertia));
      bodies.back().group = 0;
    }
    const auto c = [&](const std::vector<Pose>& poses) {
      auto all = coordinates_of(poses[0], poses[1], def);
      if ((held & 7u) == 7u) {  // a point is a point in any axes; the world's are cheapest
        all.head<3>() =
            poses[1].to_world(def.frame_b.anchor) - poses[0].to_world(def.frame_a.anchor);
      }
      std::vector<double> rows;
      for (unsigned i = 0; i < 6; ++i) {
        if ((held >> i & 1u) != 0) rows.push_back(all[i]);
      }
      if (held == 0b1000000u) rows.push_back(all[6] - def.cone);
      return Eigen::VectorXd(
          Eigen::Map<Eigen::VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size())));
    };
    const Eigen::VectorXd expected = expected_projection(c, bodies);
    JointBlock joints;
    joints.add(world, def);
    // The step begins where all rows hold: what is violated then is closed without velocity.
    std::vector<SolverBody> joined = bodies;
    joined[1].q = joined[0].q * def.frame_a.basis * def.frame_b.basis.conjugate();
    joined[1].x = joined[0].x + joined[0].q * def.frame_a.anchor - joined[1].q * def.frame_b.anchor;
    joints.begin_step({.bodies = joined, .h = 0.01});
    const SubstepContext context{.bodies = bodies, .h = 0.01};
    joints.begin_substep(context);
    joints.project(context);
    // A turn of more than half a radian is taken in parts, along the same line.
    const Eigen::VectorXd moved = corrections_of(bodies);
    const double turned = std::max(expected.segment<3>(3).norm(), expected.segment<3>(9).norm());
    INFO("held " << held << ", turned " << turned);
    CHECK((moved - std::min(1.0, 0.5 / turned) * expected).norm() < 1e-8 * expected.norm());
  }
}

TEST_CASE("joint: a free pair keeps linear and angular momentum, in either order of its bodies",
          "[pbd][joint][analytic][long]") {
  for (const int kind : {0, 1, 2, 3}) {
    for (const bool swapped : {false, true}) {
      World world(weightless());
      auto& joints = world.add_block<JointBlock>();
      BodyDef def = box_def(1.0, kHalf, Vec3::Zero());
      def.twist = {Vec3(0.2, -0.1, 0.3), Vec3(0.0, 2.0, 1.0)};
      BodyId a = world.add_body(def);
      def = box_def(3.0, kHalf, Vec3(0.6, 0.2, 0.0), turn(Vec3(0.3, 0.2, 0.1)));
      def.twist = {Vec3(-0.1, 0.4, 0.0), Vec3(1.0, 0.0, -2.0)};
      BodyId b = world.add_body(def);
      if (swapped) std::swap(a, b);
      const Vec3 anchor(0.3, 0.1, 0.05);
      const Vec3 axis(1.0, 2.0, -1.0);
      if (kind == 0) joints.add(world, fixed_joint_at(world, a, b, anchor));
      if (kind == 1) joints.add(world, ball_joint_at(world, a, b, anchor, axis));
      if (kind == 2) joints.add(world, hinge_joint_at(world, a, b, anchor, axis));
      if (kind == 3) joints.add(world, slider_joint_at(world, a, b, anchor, axis));
      const Vec3 p = linear_momentum(world);
      const Vec3 l = angular_momentum(world);
      Solver solver({.joint_iterations = 100, .joint_tolerance = 1e-14});
      solver.step(world, kFrame);  // the velocities fit the joint from here on
      const double energy = world.kinetic_energy();
      double drift = 0.0;
      run(world, solver, 3.0,
          [&] { drift = std::max(drift, std::abs(world.kinetic_energy() - energy)); });
      INFO("kind " << kind << (swapped ? " swapped" : "") << ", energy drift " << drift / energy);
      CHECK((linear_momentum(world) - p).norm() < 1e-11);
      CHECK((angular_momentum(world) - l).norm() < 1e-6 * l.norm());
      CHECK(drift < 1e-4 * energy);
    }
  }
}

TEST_CASE("joint: forces and torques of a shelf are those of statics", "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3(0.5, 0.0, 0.0));
  m.add_joint(fixed_joint_at(m.world, {}, m.body, Vec3::Zero()));
  m.run(0.5);
  CHECK((m.state().force - Vec3(0.0, 0.0, 2.0 * kGravity)).norm() < 1e-6);
  CHECK((m.state().torque - Vec3(0.0, -0.5 * 2.0 * kGravity, 0.0)).norm() < 1e-6);
  CHECK((m.world.pose(m.body).position - Vec3(0.5, 0.0, 0.0)).norm() < 1e-6);
  CHECK(m.state().residual < 1e-6);
}

TEST_CASE("joint: a fixed joint of given compliance gives way by load times compliance",
          "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3(0.5, 0.0, 0.0));
  FixedJointDef def = fixed_joint_at(m.world, {}, m.body, Vec3::Zero());
  def.compliance = 1e-4;
  def.damping = 200.0;
  def.angular_compliance = 1e-3;
  def.angular_damping = 10.0;
  m.add_joint(def);
  m.run(5.0);
  CHECK(m.state().position[2] == Approx(-2.0 * kGravity * 1e-4).epsilon(1e-3));
  // The lever arm shortens by 1 - cos, 5e-5 here.
  CHECK(m.state().position[4] == Approx(0.5 * 2.0 * kGravity * 1e-3).epsilon(1e-3));
}

TEST_CASE("joint: a hinge is a physical pendulum with the period of the elliptic integral",
          "[pbd][joint][analytic]") {
  for (const double amplitude : {10.0, 170.0}) {
    const double start = amplitude * kPi / 180.0;
    Mounted m(WorldDef{});
    m.add_box(1.0, Vec3(0.5 * std::sin(start), 0.0, -0.5 * std::cos(start)),
              turn(Vec3(0.0, -start, 0.0)));
    m.add_joint(hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitY()));
    const double inertia = m.world.props(m.body).inertia(1, 1) + 0.25;
    const double energy = m.world.mechanical_energy();
    const double scale = energy + 0.5 * kGravity;
    // The energy of a half-step velocity swings with the body, so ends are compared by their peaks.
    double first = 0.0;
    double last = 0.0;
    std::vector<double> angles;
    m.run(10.0, [&] {
      const double now = m.world.mechanical_energy() - energy;
      double& peak = m.world.time() < 4.0 ? first : last;
      if (m.world.time() < 4.0 || m.world.time() > 6.0) peak = std::max(peak, now);
      const Vec3& p = m.world.pose(m.body).position;
      angles.push_back(std::atan2(p.x(), -p.z()));
    });
    const double period = pendulum_period(std::sqrt(0.5 * kGravity / inertia), start);
    INFO("amplitude " << amplitude << ", energy " << (last - first) / scale << ", period "
                      << mean_period(angles, kFrame) / period - 1.0);
    CHECK(std::abs(last - first) < 0.003 * scale);
    CHECK(last < 0.01 * scale);
    CHECK(std::abs(mean_period(angles, kFrame) / period - 1.0) < 1e-3);
  }
}

TEST_CASE("joint: a hinge counts turns", "[pbd][joint][unit]") {
  Mounted m;
  m.add_box(1.0, Vec3(0.3, 0.0, 0.0));
  m.add_joint(hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ()));
  m.world.set_twist(m.body, {Vec3(0.0, 3.0, 0.0), Vec3(0.0, 0.0, 10.0)});
  m.run(2.0);
  CHECK(m.state().position[3] == Approx(20.0).epsilon(1e-4));
}

TEST_CASE("joint: a slider runs without friction and without turning", "[pbd][joint][analytic]") {
  Mounted m(WorldDef{});
  m.add_box(1.0, Vec3(0.3, 0.1, 0.2));
  const Vec3 axis = Vec3(1.0, 0.0, -1.0).normalized();
  m.add_joint(slider_joint_at(m.world, {}, m.body, Vec3::Zero(), axis));
  const Vec3 start = m.world.pose(m.body).position;
  m.run(1.0);
  // Symplectic Euler: x = a t (t + h) / 2.
  const double way = 0.5 * kGravity / std::sqrt(2.0) * 1.0 * (1.0 + kFrame / 10.0);
  CHECK((m.world.pose(m.body).position - start - way * axis).norm() < 1e-5);
  CHECK(m.state().position[0] == Approx(way).epsilon(1e-6));
  CHECK(angle_between(m.world.pose(m.body).orientation, Quat::Identity()) < 1e-7);
}

TEST_CASE("joint: it breaks at its force and at its torque, and not below",
          "[pbd][joint][analytic]") {
  for (const bool torque : {false, true}) {
    for (const double part : {0.99, 1.01}) {
      Mounted m(WorldDef{});
      m.add_box(2.0, Vec3(0.5, 0.0, 0.0));
      FixedJointDef def = fixed_joint_at(m.world, {}, m.body, Vec3::Zero());
      if (torque) {
        def.break_torque = part * 2.0 * kGravity * 0.5;
      } else {
        def.break_force = part * 2.0 * kGravity;
      }
      m.add_joint(def);
      m.run(0.5);
      CHECK(m.state().broken == (part < 1.0));
      CHECK((m.world.pose(m.body).position.z() < -0.5) == (part < 1.0));
      if (part > 1.0) continue;
      CHECK(m.state().force.norm() == 0.0);
      m.joints->set_enabled(m.joint, true);
      m.solver.step(m.world, kFrame);
      CHECK(m.joints->size() == 1);
    }
  }
}

TEST_CASE("joint: switched off it does nothing, switched on it holds again", "[pbd][joint][unit]") {
  Mounted m(WorldDef{});
  m.add_box(1.0, Vec3::Zero());
  m.add_joint(fixed_joint_at(m.world, {}, m.body, Vec3::Zero()));
  m.joints->set_enabled(m.joint, false);
  m.run(0.1);
  CHECK(m.world.twist(m.body).linear.z() == Approx(-0.1 * kGravity).epsilon(1e-9));
  m.joints->set_enabled(m.joint, true);
  m.run(0.5);
  CHECK(m.world.pose(m.body).position.norm() < 1e-6);
}

TEST_CASE("joint: a bad definition is refused naming field, value and rule",
          "[pbd][joint][fault]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  World world;
  auto& joints = world.add_block<JointBlock>();
  const BodyId a = world.add_body({});
  const BodyId b = world.add_body({});
  const BodyId stale = world.add_body({});
  world.remove_body(stale);
  using Def = SixDofJointDef;
  const auto refused = [&](const char* field, const char* value, const char* rule,
                           const std::function<void(Def&)>& spoil) {
    Def def{.a = a, .b = b};
    spoil(def);
    const std::string message = refusal([&] { joints.add(world, def); });
    INFO("\"" << message << "\"");
    CHECK(names(message, std::string("joint: ") + field, value, rule));
  };
  refused("a", "body 2", "a body of this world", [&](Def& d) { d.a = stale; });
  refused("b", "body 2", "a body of this world", [&](Def& d) { d.b = stale; });
  refused("b", "is 1", "another body than a", [&](Def& d) { d.a = b; });
  refused("frame_a.anchor", "nan", "finite", [&](Def& d) { d.frame_a.anchor.x() = kNan; });
  refused("frame_b.basis", "is 2", "unit", [&](Def& d) { d.frame_b.basis.w() = 2.0; });
  refused("frame_b.anchor", "-inf", "finite", [&](Def& d) { d.frame_b.anchor.z() = -kUnlimited; });
  refused("linear[1].compliance", "is -1", "at least 1e-100",
          [&](Def& d) { d.linear[1].compliance = -1.0; });
  refused("linear[0].compliance", "nan", "finite", [&](Def& d) { d.linear[0].compliance = kNan; });
  refused("linear[2].damping", "is -2", ">= 0", [&](Def& d) { d.linear[2].damping = -2.0; });
  refused("linear[2].damping", "inf", "finite", [&](Def& d) { d.linear[2].damping = kUnlimited; });
  refused("angular[0].upper", "is -1", ">= lower",
          [&](Def& d) { d.angular[0] = limit(1.0, -1.0); });
  refused("angular[2].motor.max_force", "is 0", "> 0",
          [&](Def& d) { d.angular[2].motor.max_force = 0.0; });
  refused("linear[0].spring.stiffness", "is 5", "locked", [&](Def& d) {
    d.linear[0] = lock();
    d.linear[0].spring.stiffness = 5.0;
  });
  refused("cone", "is -1", "> 0", [&](Def& d) { d.cone = -1.0; });
  refused("cone_compliance", "is -1", "at least 1e-100", [&](Def& d) { d.cone_compliance = -1.0; });
  refused("cone_damping", "is -2", ">= 0", [&](Def& d) { d.cone_damping = -2.0; });
  refused("angular[1].freedom", "is 1", "cone", [&](Def& d) {
    d.cone = 1.0;
    d.angular[1] = lock();
  });
  refused("break_torque", "nan", ">= 0", [&](Def& d) { d.break_torque = kNan; });
  CHECK(joints.size() == 0);
  const JointId id = joints.add(world, SixDofJointDef{.a = a, .b = b});
  joints.remove(id);
  CHECK(names(refusal([&] { joints.at(id); }), "joint: id 0", "generation 0", "no joint"));
  CHECK(names(refusal([&] { ball_joint_at(world, a, stale, Vec3::Zero()); }), "joint: b", "body 2",
              "a body of this world"));
  CHECK(names(refusal([&] { ball_joint_at(world, stale, a, Vec3::Zero()); }), "joint: a", "body 2",
              "a body of this world"));
  CHECK(names(refusal([&] { hinge_joint_at(world, a, b, Vec3::Zero(), Vec3::Zero()); }),
              "joint: axis_w", "is 0", "longer"));
  CHECK(names(refusal([&] { six_dof_joint_at(world, a, b, Vec3::Zero(), Vec3::Zero()); }),
              "joint: axis_w", "is 0", "longer"));
  const Vec3 at(0.3, 0.2, 0.1), along(0.0, 1.0, 1.0);
  const HingeJointDef hinge = hinge_joint_at(world, a, b, at, along);
  const SixDofJointDef six = six_dof_joint_at(world, a, b, at, along);
  CHECK(six.frame_b.basis.coeffs() == hinge.frame_b.basis.coeffs());
  CHECK(six.frame_b.anchor == hinge.frame_b.anchor);
  joints.add(world, SixDofJointDef{.a = a, .b = b});
  world.remove_body(a);
  CHECK(joints.size() == 0);
}

TEST_CASE("joint: reports are of the last step", "[pbd][joint][unit]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = {.mode = MotorMode::Velocity, .target = 50.0, .max_force = 1.0};
  m.add_joint(def);
  m.run(0.1);
  REQUIRE(m.state().load[3] == Approx(1.0));
  def.axis.motor.mode = MotorMode::Off;
  m.joints->set(m.world, m.joint, def);
  m.run(0.1);
  CHECK(m.state().load[3] == 0.0);
  SixDofJointDef loose = def;
  for (JointAxis& axis : loose.linear) axis = {};
  for (JointAxis& axis : loose.angular) axis = {};
  SixDofJointDef pulling = loose;
  pulling.linear[0].spring = {.stiffness = 10.0, .rest = 1.0};
  m.joints->set(m.world, m.joint, pulling);
  m.run(0.1);
  REQUIRE(m.state().force.norm() > 1.0);
  m.joints->set(m.world, m.joint, loose);
  m.run(0.1);
  CHECK(m.state().force.norm() == 0.0);
  CHECK(m.state().load[0] == 0.0);
}

TEST_CASE("joint: the step in which it breaks reports the force that was too much",
          "[pbd][joint][unit]") {
  Mounted m(WorldDef{});
  m.add_box(2.0, Vec3::Zero());
  FixedJointDef def = fixed_joint_at(m.world, {}, m.body, Vec3::Zero());
  def.break_force = 30.0;  // its weight is 20 N
  m.add_joint(def);
  m.run(0.2);
  REQUIRE_FALSE(m.state().broken);
  m.world.apply_force(m.body, Vec3(40.0, 0.0, 0.0));
  m.solver.step(m.world, kFrame);
  REQUIRE(m.state().broken);
  CHECK(m.state().force.norm() == Approx(std::hypot(40.0, 2.0 * kGravity)).epsilon(1e-3));
  m.solver.step(m.world, kFrame);
  CHECK(m.state().force.norm() == 0.0);
}

TEST_CASE("joint: after a spoiled step it is as it was, turns included", "[pbd][joint][fault]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  HingeJointDef def = hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
  def.axis.motor = {.mode = MotorMode::Velocity, .target = 20.0};
  m.add_joint(def);
  m.run(1.0);
  const double turned = m.state().position[3];
  REQUIRE(turned == Approx(20.0).epsilon(1e-3));
  const Twist twist = m.world.twist(m.body);
  m.world.set_twist(m.body, {Vec3::Constant(1e307), Vec3(0.0, 0.0, 1e307)});
  REQUIRE(m.solver.step(m.world, kFrame).status == StepStatus::NonFinite);
  CHECK(m.state().position[3] == turned);
  CHECK(m.state().force.allFinite());
  CHECK(m.state().torque.allFinite());
  for (const double load : m.state().load) CHECK(std::isfinite(load));
  m.world.set_twist(m.body, twist);
  m.solver.step(m.world, kFrame);
  CHECK(m.state().position[3] == Approx(turned + 20.0 * kFrame).epsilon(1e-3));
}

TEST_CASE("joint: limits that leave nothing and compliances without an inverse are refused",
          "[pbd][joint][fault]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  const auto refused = [&](const JointAxis& axis) {
    SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX());
    def.axis = axis;
    return refusal([&] { m.add_joint(def); });
  };
  CHECK(names(refused(limit(kUnlimited, kUnlimited)), "linear[0].lower", "inf", "infinity"));
  CHECK(names(refused(limit(-kUnlimited, -kUnlimited)), "linear[0].upper", "-inf", "infinity"));
  CHECK(refused(limit(-kUnlimited, kUnlimited)).empty());
  JointAxis soft = limit(-0.1, 0.1);
  soft.compliance = 1e-313;
  CHECK(names(refused(soft), "linear[0].compliance", "1e-313", "1e-100"));
}

TEST_CASE("joint: an axis may be of any length above 1e-9", "[pbd][joint][fault]") {
  Mounted m;
  m.add_box(2.0, Vec3::Zero());
  for (const double length : {1e-8, 1.0, 1e200}) {
    const HingeJointDef def =
        hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), length * Vec3(0.0, 0.6, 0.8));
    CHECK((def.frame_a.basis * Vec3::UnitX() - Vec3(0.0, 0.6, 0.8)).norm() < 1e-12);
  }
  CHECK(names(refusal([&] {
                (void)hinge_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3(1e-10, 0.0, 0.0));
              }),
              "axis_w", "1e-10", "1e-9"));
}

}  // namespace joint_test
