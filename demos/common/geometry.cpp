// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/geometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace tandem::demos {

namespace {

/// Half of a box's shadow on the unit direction `axis`, m.
double reach(const pbd::Mat3& axes, const pbd::Vec3& half, const pbd::Vec3& axis) {
  return (axes.transpose() * axis).cwiseAbs().dot(half);
}

/// A box along x, for the sweep.
struct Extent {
  double low, high;
  std::size_t body;
};

}  // namespace

double box_overlap(const pbd::Pose& a, const pbd::Vec3& half_a, const pbd::Pose& b,
                   const pbd::Vec3& half_b) {
  const pbd::Mat3 axes_a = a.orientation.toRotationMatrix();
  const pbd::Mat3 axes_b = b.orientation.toRotationMatrix();
  const pbd::Vec3 between = b.position - a.position;
  double least = std::numeric_limits<double>::max();
  const auto try_axis = [&](const pbd::Vec3& axis) {
    const double depth =
        reach(axes_a, half_a, axis) + reach(axes_b, half_b, axis) - std::abs(axis.dot(between));
    least = std::min(least, depth);
    return depth > 0.0;
  };
  for (int i = 0; i < 3; ++i) {
    if (!try_axis(axes_a.col(i)) || !try_axis(axes_b.col(i))) return 0.0;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const pbd::Vec3 cross = axes_a.col(i).cross(axes_b.col(j));
      const double norm = cross.norm();
      if (norm < 1e-6) continue;  // parallel edges: the faces have decided
      if (!try_axis(cross / norm)) return 0.0;
    }
  }
  return least;
}

double ground_overlap(const pbd::Pose& pose, const pbd::Vec3& half) {
  const pbd::Mat3 axes = pose.orientation.toRotationMatrix();
  return std::max(0.0, reach(axes, half, pbd::Vec3::UnitZ()) - pose.position.z());
}

void append_penetrations(const Scene& scene, std::vector<double>& out) {
  std::vector<Extent> extents;
  extents.reserve(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const pbd::Pose& pose = scene.pose(scene.bodies[i]);
    const pbd::Vec3& half = scene.bodies[i].half_extents;
    const double r = reach(pose.orientation.toRotationMatrix(), half, pbd::Vec3::UnitX());
    extents.push_back({pose.position.x() - r, pose.position.x() + r, i});
    const double below = ground_overlap(pose, half);
    if (below > 0.0) out.push_back(below);
  }
  std::sort(extents.begin(), extents.end(),
            [](const Extent& a, const Extent& b) { return a.low < b.low; });
  for (std::size_t i = 0; i < extents.size(); ++i) {
    for (std::size_t j = i + 1; j < extents.size() && extents[j].low < extents[i].high; ++j) {
      const SceneBody& a = scene.bodies[extents[i].body];
      const SceneBody& b = scene.bodies[extents[j].body];
      const double depth =
          box_overlap(scene.pose(a), a.half_extents, scene.pose(b), b.half_extents);
      if (depth > 0.0) out.push_back(depth);
    }
  }
}

}  // namespace tandem::demos
