// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact_patch.h"
#include "tandem/collision/triangle_mesh.h"

// Common to spheres and other convex shapes on a TriangleMesh or a HeightField: the search for near
// triangles, and matching of contacts with those of the last step.

namespace tandem::collision {

/// Cosine above which a cluster continues one of the last step.
inline constexpr double kSameAsBefore = 0.9;
/// Cosine above which two normals count as one. With planes up to 8 degrees apart in one manifold,
/// bodies rolling in a bowl sank into the next plane and were lifted: a ball came to 8 times its
/// energy in 10 s, a cylinder to twice.
inline constexpr double kSameNormal = 1.0 - 1e-6;
/// Sine by which a normal may leave a Voronoi region.
inline constexpr double kRegionSlop = 1e-4;
/// m by which a point may be beside a triangle and still count as over it.
inline constexpr double kOver = 1e-6;
/// Share of its size by which the search box for triangles is widened.
inline constexpr double kListShare = 0.25;

/// Whether a point is over or under the triangle p, q, r, or beside it by no more than `slop`, m.
inline bool spans(const Vec3& front, const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& point,
                  double slop) {
  const auto inside = [&](const Vec3& from, const Vec3& to) {
    const Vec3 along = to - from;
    return front.dot(along.cross(point - from)) >= -slop * along.norm();
  };
  return inside(p, q) && inside(q, r) && inside(r, p);
}

/// A patch of the last step, normal in the mesh frame.
struct PatchTrace {
  Vec3 normal_l;
  std::array<std::uint32_t, 4> features;
  std::uint16_t cluster = 0;
  std::uint8_t count = 0;
};

inline bool was_touched(std::span<const PatchTrace> previous, const Vec3& front_l) {
  return std::any_of(previous.begin(), previous.end(), [&](const PatchTrace& patch) {
    return patch.count > 0 && -patch.normal_l.dot(front_l) > kSameAsBefore;
  });
}

/// The patch of the last step that the cluster continues, or null.
/// @param taken  entries that have a `cluster` already
const PatchTrace* match(const Vec3& normal_l, std::span<const PatchTrace> previous,
                        const auto& taken) {
  const PatchTrace* best = nullptr;
  double cosine = kSameAsBefore;
  for (const PatchTrace& patch : previous) {
    const double value = patch.normal_l.dot(normal_l);
    const bool used = std::any_of(taken.begin(), taken.end(),
                                  [&](const auto& t) { return t.cluster == patch.cluster; });
    if (!used && value > cosine) {
      cosine = value;
      best = &patch;
    }
  }
  return best;
}

std::uint32_t free_number(std::span<const PatchTrace> previous, const auto& taken) {
  for (std::uint32_t number = 0;; ++number) {
    const auto has_it = [&](const auto& one) { return one.cluster == number; };
    if (!std::any_of(previous.begin(), previous.end(), has_it) &&
        !std::any_of(taken.begin(), taken.end(), has_it)) {
      return number;
    }
  }
}

/// Fills the list, unless it is still valid; searches a box somewhat larger than needed.
void find_triangles(const auto& surface, const Aabb& bounds, TriangleList& list) {
  if (list.filled && Aabb{list.min, list.max}.contains(bounds)) {
    const Vec3 slack = (list.max - list.min) - (bounds.max - bounds.min);
    if (slack.maxCoeff() < (bounds.max - bounds.min).maxCoeff()) return;
  }
  const Aabb wide = bounds.expanded(kListShare * (bounds.max - bounds.min).maxCoeff());
  list.triangles.clear();
  surface.query(wide, list.triangles);
  list.min = wide.min;
  list.max = wide.max;
  list.filled = true;
}

}  // namespace tandem::collision
