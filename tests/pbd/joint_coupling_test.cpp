// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/joint_coupling.h"

#include <cstdint>
#include <set>
#include <vector>

#include "joint_fixture.h"
#include "support/catch.h"

/// Two joints whose coordinates are in proportion.
namespace joint_coupling_test {

using namespace tandem::pbd;
using namespace tandem::testing;

struct Geared {
  World world;
  JointBlock* joints = &world.add_block<JointBlock>();
  JointCouplingBlock* couplings = &world.add_block<JointCouplingBlock>();
  std::vector<BodyId> bodies;
  std::vector<JointId> ids;
  std::vector<ConstraintId> rows;
  Solver solver{{.sleep_after = 0.0}};

  explicit Geared(const WorldDef& def = weightless()) : world(def) {}
  BodyId add_rod(double mass, double length, const Vec3& at) {
    bodies.push_back(world.add_body(box_def(mass, Vec3(0.5 * length, 0.02, 0.02), at)));
    return bodies.back();
  }
  JointId add_hinge(BodyId a, BodyId b, const Vec3& at) {
    ids.push_back(joints->add(world, hinge_joint_at(world, a, b, at, Vec3::UnitY())));
    return ids.back();
  }
  void couple(JointId one, JointId two, double ratio) {
    rows.push_back(couplings->add(world, JointCoupling::between(*joints, one, two, ratio)));
  }
  double off(std::size_t row, double ratio, JointId one, JointId two) const {
    CHECK(couplings->at(rows[row]).residual() < 1e-4);
    return std::abs(joints->at(two).position[3] - ratio * joints->at(one).position[3]);
  }
  double hinges_off() const {
    double most = 0.0;
    for (const JointId id : ids) most = std::max(most, joints->at(id).residual);
    return most;
  }
  double energy() const {
    double sum = world.kinetic_energy();
    for (const BodyId body : bodies) {
      sum -= world.props(body).mass * world.gravity().dot(world.pose(body).position);
    }
    return sum;
  }
};

TEST_CASE("joint coupling: gears turn as one inertia, by both their loads",
          "[pbd][joint][coupling][analytic]") {
  const double ratio = GENERATE(-2.0, 0.5, 7.0);
  Geared g;
  const BodyId a = g.add_rod(2.0, 0.3, Vec3::Zero());
  const BodyId b = g.add_rod(1.0, 0.2, Vec3(0.5, 0.0, 0.0));
  const JointId one = g.add_hinge({}, a, Vec3::Zero());
  const JointId two = g.add_hinge({}, b, Vec3(0.5, 0.0, 0.0));
  g.couple(one, two, ratio);
  const double inertia =
      g.world.props(a).inertia(1, 1) + ratio * ratio * g.world.props(b).inertia(1, 1);
  double most = 0.0;
  run(g.world, g.solver, 2.0, [&] {
    g.world.apply_torque(a, 0.02 * Vec3::UnitY());
    g.world.apply_torque(b, 0.013 * Vec3::UnitY());
    most = std::max(most, g.off(0, ratio, one, two));
  });
  CHECK(most < 1e-4);
  const double time = 2.0 - kFrame;  // from the end of the first step on
  const double turned = 0.5 * (0.02 + ratio * 0.013) / inertia * time * time;
  CHECK(g.joints->hinge_angle(one) == Approx(turned).epsilon(1e-2));
  CHECK(g.hinges_off() < 1e-5);
}

TEST_CASE("joint coupling: fingers that hang on their ends keep their ratio and gain no energy",
          "[pbd][joint][coupling][energy]") {
  Geared g(WorldDef{});
  const BodyId a = g.add_rod(1.0, 0.5, Vec3(0.25, 0.0, 0.0));
  const BodyId b = g.add_rod(0.5, 0.4, Vec3(0.7, 0.0, 0.0));
  const BodyId c = g.add_rod(0.3, 0.2, Vec3(1.0, 0.0, 0.0));
  const JointId one = g.add_hinge({}, a, Vec3::Zero());
  const JointId two = g.add_hinge(a, b, Vec3(0.5, 0.0, 0.0));
  g.couple(one, two, 0.8);
  g.add_hinge(b, c, Vec3(0.9, 0.0, 0.0));
  const double start = g.energy();
  double most = 0.0;
  double farthest = 0.0;
  run(g.world, g.solver, 5.0, [&] {
    most = std::max(most, g.energy() - start);
    CHECK(g.off(0, 0.8, one, two) < 1e-4);
    farthest = std::max(farthest, std::abs(g.joints->hinge_angle(one)));
    CHECK(g.hinges_off() < 1e-4);
  });
  CHECK(farthest > 1.0);
  // J, of a fall by 0.5 m: a step's velocity is that of half a substep before.
  CHECK(most < 0.02);
}

TEST_CASE("joint coupling: a floating system keeps its momentum", "[pbd][joint][coupling]") {
  Geared g;
  const BodyId palm = g.add_rod(2.0, 0.4, Vec3::Zero());
  const BodyId left = g.add_rod(0.5, 0.3, Vec3(-0.35, 0.0, 0.0));
  const BodyId right = g.add_rod(0.7, 0.3, Vec3(0.35, 0.0, 0.0));
  const JointId one = g.add_hinge(palm, left, Vec3(-0.2, 0.0, 0.0));
  const JointId two = g.add_hinge(palm, right, Vec3(0.2, 0.0, 0.0));
  g.couple(one, two, -1.0);
  g.world.set_twist(left, {Vec3(0.0, 0.0, 0.3), Vec3(0.0, 2.0, 0.0)});
  const auto momentum = [&] {
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (const BodyId body : g.bodies) {
      const Mat3 turn = g.world.pose(body).orientation.toRotationMatrix();
      const Vec3 p = g.world.props(body).mass * g.world.twist(body).linear;
      const Vec3 spin =
          turn * g.world.props(body).inertia * turn.transpose() * g.world.twist(body).angular;
      sum.head<3>() += p;
      sum.tail<3>() += g.world.pose(body).position.cross(p) + spin;
    }
    return sum;
  };
  const Eigen::Matrix<double, 6, 1> start = momentum();
  const double energy = g.energy();
  run(g.world, g.solver, 3.0, [&] {
    CHECK((momentum() - start).head<3>().norm() < 1e-9);
    CHECK((momentum() - start).tail<3>().norm() < 1e-3 * start.norm());
    CHECK(g.energy() < energy * (1.0 + 1e-3));
    CHECK(g.off(0, -1.0, one, two) < 1e-4);
  });
}

TEST_CASE("joint coupling: a rack goes with its pinion", "[pbd][joint][coupling][analytic]") {
  Geared g;
  const BodyId pinion = g.add_rod(1.0, 0.2, Vec3::Zero());
  const BodyId rack = g.add_rod(3.0, 0.5, Vec3(0.0, 0.0, 0.1));
  const JointId turn = g.add_hinge({}, pinion, Vec3::Zero());
  const JointId way = g.joints->add(
      g.world, slider_joint_at(g.world, {}, rack, Vec3(0.0, 0.0, 0.1), Vec3::UnitX()));
  g.couple(turn, way, 0.1);
  run(g.world, g.solver, 1.0, [&] { g.world.apply_torque(pinion, 0.1 * Vec3::UnitY()); });
  const double inertia = g.world.props(pinion).inertia(1, 1) + 3.0 * 0.01;
  const double time = 1.0 - kFrame;  // from the end of the first step on
  CHECK(g.joints->hinge_angle(turn) == Approx(0.5 * 0.1 / inertia * time * time).epsilon(1e-2));
  CHECK(std::abs(g.joints->slider_position(way) - 0.1 * g.joints->hinge_angle(turn)) < 1e-5);
}

TEST_CASE("joint coupling: it is saved, goes with any of its bodies, and is checked",
          "[pbd][joint][coupling][errors]") {
  Geared g;
  const BodyId palm = g.add_rod(2.0, 0.4, Vec3::Zero());
  const BodyId left = g.add_rod(0.5, 0.3, Vec3(-0.35, 0.0, 0.0));
  const BodyId right = g.add_rod(0.7, 0.3, Vec3(0.35, 0.0, 0.0));
  const JointId one = g.add_hinge(palm, left, Vec3(-0.2, 0.0, 0.0));
  const JointId two = g.add_hinge(palm, right, Vec3(0.2, 0.0, 0.0));
  g.couple(one, two, -1.0);
  g.world.set_twist(left, {Vec3(0.0, 0.0, 0.3), Vec3(0.0, 2.0, 0.0)});
  run(g.world, g.solver, 0.5);
  const std::vector<std::byte> bytes = g.world.snapshot();
  run(g.world, g.solver, 0.5);
  const std::uint64_t hash = g.world.hash();
  g.world.restore(bytes);
  run(g.world, g.solver, 0.5);
  CHECK(g.world.hash() == hash);

  JointCoupling::Def def = JointCoupling::between(*g.joints, one, two, 1.0);
  def.ratio = HUGE_VAL;
  CHECK(names(refusal([&] { g.couplings->add(g.world, def); }), "ratio", "inf", "finite"));
  def = JointCoupling::between(*g.joints, one, one, 1.0);
  CHECK(names(refusal([&] { g.couplings->add(g.world, def); }), "two.b", "", "another body"));
  const JointId ball =
      g.joints->add(g.world, ball_joint_at(g.world, {}, right, Vec3(0.5, 0.0, 0.0)));
  CHECK_FALSE(refusal([&] { JointCoupling::between(*g.joints, one, ball, 1.0); }).empty());
  g.world.remove_body(palm);
  CHECK(g.couplings->size() == 0);
  run(g.world, g.solver, 0.1);
}

// It measures on, and static bodies that nothing names are not there to be measured.
TEST_CASE("joint coupling: one that is switched off names all its bodies",
          "[pbd][joint][coupling]") {
  Geared g;
  const BodyId palm = g.add_rod(2.0, 0.4, Vec3::Zero());
  const BodyId left = g.add_rod(0.5, 0.3, Vec3(-0.35, 0.0, 0.0));
  const BodyId wrist = g.add_rod(2.0, 0.4, Vec3::Zero());
  const BodyId right = g.add_rod(0.7, 0.3, Vec3(0.35, 0.0, 0.0));
  const JointId one = g.add_hinge(palm, left, Vec3(-0.2, 0.0, 0.0));
  const JointId two = g.add_hinge(wrist, right, Vec3(0.2, 0.0, 0.0));
  JointCoupling::Def def = JointCoupling::between(*g.joints, one, two, 1.0);
  const auto named = [&](bool enabled) {
    def.enabled = enabled;
    const ConstraintId id = g.couplings->add(g.world, def);
    std::vector<ConstraintEdge> active, idle;
    g.couplings->append_edges(active);
    g.couplings->append_idle(idle);
    g.couplings->remove(id);
    std::set<std::uint32_t> bodies;
    for (const ConstraintEdge& edge : enabled ? active : idle) {
      bodies.insert({edge.body_a, edge.body_b});
    }
    CHECK((enabled ? idle : active).empty());
    return bodies;
  };
  const std::set<std::uint32_t> all{palm.index, left.index, wrist.index, right.index};
  for (const bool enabled : {true, false}) {
    std::set<std::uint32_t> bodies = named(enabled);
    bodies.erase(BodyId::kNone);
    CHECK(bodies == all);
  }
}

}  // namespace joint_coupling_test
