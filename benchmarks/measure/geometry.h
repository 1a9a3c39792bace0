// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "demos/engine/scene.h"

/// Distances between sharp shapes, independent of all engines.
namespace tandem::bench {

/// Largest separation over the 15 axes of two boxes: minus the depth of an overlap, otherwise a
/// lower bound of their distance.
double box_box_gap(const Vec3& half_a, const Pose& a, const Vec3& half_b, const Pose& b);

/// Gap between a box's deepest corner and the fixed box's face plane of largest separation.
double box_wall_gap(const Vec3& half, const Pose& pose, const Vec3& half_wall, const Pose& wall);

double sphere_box_gap(double radius, const Vec3& centre, const Vec3& half_wall, const Pose& wall);

/// The point of the triangle nearest to `p`.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// A surface of triangles with one height above each point of the plane.
class HeightSurface {
 public:
  explicit HeightSurface(const MeshData& mesh);

  /// m; none outside the border.
  std::optional<double> height(double x, double y) const;
  /// Distance (m) of `p` from the surface, negative below it; none beyond 1 m.
  std::optional<double> distance(const Vec3& p) const;

 private:
  std::size_t column(double x) const;
  std::size_t row(double y) const;

  static constexpr std::size_t kBins = 64;
  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<std::vector<std::uint32_t>> bins_;  ///< triangles by the bins of their bounds
  Vec3 low_, high_;
};

}  // namespace tandem::bench
