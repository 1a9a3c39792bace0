// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "copies/measures.h"

#include <algorithm>
#include <cmath>

#include "measure/geometry.h"

namespace tandem::peers_bench {

using pbd::Vec3;

double apart(const Copy& a, const Copy& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    sum +=
        (a.world->pose(a.bodies[i]).position - b.world->pose(b.bodies[i]).position).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.bodies.size()));
}

double deepest_overlap(const Copy& copy) {
  double deepest = 0.0;
  const auto look = [&](const BoxBody& a, const BoxBody& b) {
    const pbd::Pose& pose_a = copy.world->pose(a.body);
    const pbd::Pose& pose_b = copy.world->pose(b.body);
    deepest = std::max(deepest, -bench::box_box_gap(a.half, pose_a, b.half, pose_b));
  };
  for (std::size_t i = 0; i < copy.boxes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) look(copy.boxes[i], copy.boxes[j]);
    for (const BoxBody& wall : copy.walls) look(copy.boxes[i], wall);
  }
  return deepest;
}

double widest_joint(const Copy& copy) {
  double largest = 0.0;
  for (const pbd::JointId id : copy.joint_ids) {
    const pbd::SixDofJointDef& def = copy.joints->def(id);
    const Vec3 a = copy.world->pose(def.a).to_world(def.frame_a.anchor);
    const Vec3 b = copy.world->pose(def.b).to_world(def.frame_b.anchor);
    largest = std::max(largest, (a - b).norm());
  }
  return largest;
}

}  // namespace tandem::peers_bench
