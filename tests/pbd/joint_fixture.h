// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "support/bodies.h"
#include "tandem/pbd/joint.h"

namespace tandem::testing {

inline const Vec3 kHalf(0.2, 0.15, 0.1);  ///< m

inline pbd::JointAxis limit(double lower, double upper) {
  return {.freedom = pbd::Freedom::Limited, .lower = lower, .upper = upper};
}

/// One box and one joint to the world, without gravity unless asked for.
struct Mounted {
  pbd::World world;
  pbd::JointBlock* joints = nullptr;
  pbd::BodyId body;
  pbd::JointId joint;
  pbd::Solver solver;

  explicit Mounted(const pbd::WorldDef& def = weightless(),
                   const pbd::SolverOptions& options = {.substeps = 10, .sleep_after = 0.0})
      : world(def), joints(&world.add_block<pbd::JointBlock>()), solver(options) {}
  void add_box(double mass, const Vec3& position, const Quat& q = Quat::Identity()) {
    body = world.add_body(box_def(mass, kHalf, position, q));
  }
  void add_joint(const pbd::SixDofJointDef& def) { joint = joints->add(world, def); }
  const pbd::JointState& state() const { return joints->at(joint); }
  void run(double seconds, const std::function<void()>& each = {}) {
    testing::run(world, solver, seconds, each);
  }
};

/// `count` rods of 0.2 m along x on ball joints, the first one on the world, and a ball at the end.
struct Rope {
  static constexpr double kLink = 0.2;  ///< m
  pbd::World world;
  pbd::JointBlock* joints = nullptr;
  std::vector<pbd::BodyId> bodies;
  std::vector<pbd::JointId> ids;
  double swing_energy = 0.0;  ///< J, between level and hanging

  Rope(int count, double end_mass, double compliance = 0.0)
      : joints(&world.add_block<pbd::JointBlock>()) {
    pbd::BodyId before;
    for (int i = 0; i <= count; ++i) {
      const bool end = i == count;
      const double x = kLink * i + (end ? 0.3 : 0.5 * kLink);
      const double mass = end ? end_mass : 1.0;
      bodies.push_back(
          world.add_body(end ? ball_def(mass, 0.3, Vec3(x, 0.0, 0.0))
                             : box_def(mass, Vec3(0.5 * kLink, 0.025, 0.025), Vec3(x, 0.0, 0.0))));
      pbd::BallJointDef def = pbd::ball_joint_at(world, before, bodies.back(),
                                                 Vec3(kLink * i, 0.0, 0.0), Vec3::UnitX());
      def.compliance = compliance;
      ids.push_back(joints->add(world, def));
      before = bodies.back();
      swing_energy += mass * kGravity * x;
    }
  }
  /// m, largest distance between the anchors of a joint.
  double separation() const {
    double largest = 0.0;
    for (const pbd::JointId id : ids) largest = std::max(largest, joints->at(id).residual);
    return largest;
  }
};

}  // namespace tandem::testing
