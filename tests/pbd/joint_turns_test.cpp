// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

/// One free angular coordinate is a hinge, whatever its name.
namespace joint_turns_test {

using namespace tandem::pbd;
using namespace tandem::testing;

/// A joint that is free about one axis of its frames, which lie so that this is the same axis of
/// the world for all three.
SixDofJointDef about(std::size_t axis, const JointAxis& free) {
  SixDofJointDef def;
  def.linear.fill({.freedom = Freedom::Locked});
  def.angular.fill({.freedom = Freedom::Locked});
  def.angular[axis] = free;
  // y and z become x by two thirds and one third of a turn about the diagonal.
  const Vec3 diagonal = Vec3::Ones().normalized();
  const double third = 2.0 * std::numbers::pi / 3.0;
  const Quat name = exp_map((axis == 0 ? 0.0 : axis == 1 ? 2.0 : 1.0) * third * diagonal);
  def.frame_a.basis = exp_map(Vec3(0.3, -0.5, 0.9)) * name;
  def.frame_b.basis = def.frame_a.basis;
  def.frame_b.anchor = Vec3(-0.3, 0.1, 0.05);
  return def;
}

struct Track {
  std::vector<double> angle;  // rad
  std::vector<Vec3> place;    // m
  double spin = 0.0;          // rad/s, largest
  double kinetic = 0.0;       // J, at the start
  double gain = 0.0;          // J, largest gain
};

Track turn(std::size_t axis, const JointAxis& free, double spin, bool heavy) {
  Mounted m(heavy ? WorldDef{} : weightless());
  SixDofJointDef def = about(axis, free);
  m.add_box(1.0, -def.frame_b.anchor);
  def.b = m.body;
  m.add_joint(def);
  const Vec3 w = spin * (def.frame_a.basis * Vec3::Unit(static_cast<Eigen::Index>(axis)));
  m.world.set_twist(m.body, {w.cross(Vec3(-def.frame_b.anchor)), w});
  const double start = m.world.mechanical_energy();
  Track track{.kinetic = m.world.kinetic_energy()};
  m.run(4.0, [&] {
    track.angle.push_back(m.state().position[3 + axis]);
    track.place.push_back(m.world.pose(m.body).position);
    track.spin = std::max(track.spin, m.world.twist(m.body).angular.norm());
    track.gain = std::max(track.gain, m.world.mechanical_energy() - start);
  });
  return track;
}

TEST_CASE("joint: about y or z alone it turns as about x, over half a turn and many",
          "[pbd][joint][property]") {
  struct Case {
    JointAxis axis;
    double spin;
    bool heavy;
  };
  std::vector<Case> cases;
  for (const double speed : {1.5, -1.5, 7.0, 40.0}) {
    for (const bool heavy : {false, true}) {
      cases.push_back({{.motor = {.mode = MotorMode::Velocity, .target = speed}}, 0.0, heavy});
      cases.push_back({{}, speed, heavy});
      cases.push_back({limit(-7.5, 4.5), speed, heavy});
      cases.push_back({{.spring = {.stiffness = 0.02, .rest = 5.0}}, speed, heavy});
    }
  }
  for (const Case& c : cases) {
    INFO("spin " << c.spin << ", motor " << c.axis.motor.target << ", limited "
                 << (c.axis.freedom == Freedom::Limited) << ", heavy " << c.heavy);
    const Track x = turn(0, c.axis, c.spin, c.heavy);
    for (const std::size_t axis : {1u, 2u}) {
      const Track other = turn(axis, c.axis, c.spin, c.heavy);
      REQUIRE(other.angle.size() == x.angle.size());
      double off = 0.0;
      for (std::size_t i = 0; i < x.angle.size(); ++i) {
        off = std::max(
            {off, std::abs(other.angle[i] - x.angle[i]), (other.place[i] - x.place[i]).norm()});
      }
      CHECK(off < 1e-6);
      CHECK(other.spin == Approx(x.spin).margin(1e-6));
    }
    const double motor = std::abs(c.axis.motor.target);
    if (motor > 0.0) {
      CHECK(x.spin < motor + 1e-3);
      CHECK(std::abs(x.angle.back()) == Approx(4.0 * motor).epsilon(1e-3));
    } else if (c.axis.spring.stiffness == 0.0) {
      CHECK(x.gain < 0.02 * std::max(x.kinetic, 1.0));
    }
  }
}

TEST_CASE("joint: a body freed about another axis goes on from its present pose", "[pbd][joint]") {
  Mounted m;
  m.add_box(1.0, Vec3::Zero());
  SixDofJointDef def = six_dof_joint_at(m.world, {}, m.body, Vec3::Zero());
  def.linear.fill({.freedom = Freedom::Locked});
  def.angular = {JointAxis{}, JointAxis{.freedom = Freedom::Locked},
                 JointAxis{.freedom = Freedom::Locked}};
  m.add_joint(def);
  std::swap(def.angular[0], def.angular[2]);
  def.angular[2].motor = {.mode = MotorMode::Velocity, .target = 2.0};
  m.joints->set(m.world, m.joint, def);
  m.run(4.0);
  CHECK(m.state().position[5] == Approx(8.0).epsilon(1e-3));
  CHECK(m.world.twist(m.body).angular.norm() == Approx(2.0).margin(1e-6));
}

}  // namespace joint_turns_test
