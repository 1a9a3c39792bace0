// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::collision {

/// Share of the extent: a hull thinner than this is flat.
inline constexpr double kFlatHull = 1e-4;

/// Indices of corners, counter-clockwise seen from outside.
using HullTriangle = std::array<std::uint32_t, 3>;

struct HullPlane {
  pbd::Vec3 normal;
  double offset;
  double above(const pbd::Vec3& p) const { return normal.dot(p) - offset; }
};

inline HullPlane hull_plane(std::span<const pbd::Vec3> points, const HullTriangle& t) {
  const pbd::Vec3& a = points[t[0]];
  const pbd::Vec3 n = (points[t[1]] - a).cross(points[t[2]] - a).normalized();
  return {n, n.dot(a)};
}

/// The four points of a large tetrahedron.
struct Tetrahedron {
  std::uint32_t a, b, c, d;
  pbd::Vec3 normal;  ///< of a, b, c
  double height;     ///< m, of d over those
};

/// @throws std::invalid_argument  if they are on a line
Tetrahedron large_tetrahedron(std::span<const pbd::Vec3> points, double extent);

struct Quickhull {
  std::vector<HullTriangle> faces;
  double left_out;  ///< m above the hull, of the farthest point that is no corner
};

/// @param cut  stop at the maximum number of corners; otherwise more are an error
Quickhull quickhull(std::span<const pbd::Vec3> points, double extent, double tolerance, bool cut);

}  // namespace tandem::collision
