// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "demos/engine/scene.h"

/// Distances between sharp shapes, written for the benchmarks alone: no engine's code measures it.
namespace tandem::bench {

/// Largest separation over the 15 axes of two boxes: minus the depth where they overlap, a lower
/// bound of their distance where they do not.
double box_box_gap(const Vec3& half_a, const Pose& a, const Vec3& half_b, const Pose& b);

/// Gap between the deepest corner of a box and that face plane of a fixed box from which it sticks
/// out most: what a floor or a wall is to it.
double box_wall_gap(const Vec3& half, const Pose& pose, const Vec3& half_wall, const Pose& wall);

/// Gap between a ball and a box.
double sphere_box_gap(double radius, const Vec3& centre, const Vec3& half_wall, const Pose& wall);

/// The point of the triangle that is nearest to `p`.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// A surface of triangles with one height above each point of the plane, for balls over it.
class HeightSurface {
 public:
  explicit HeightSurface(const MeshData& mesh);

  /// Height (m) of the surface above (x, y), none beyond its border.
  std::optional<double> height(double x, double y) const;
  /// Distance (m) of `p` from the surface, negative below it; none where farther than 1 m.
  std::optional<double> distance(const Vec3& p) const;

 private:
  std::size_t column(double x) const;
  std::size_t row(double y) const;

  static constexpr std::size_t kBins = 64;
  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<std::vector<std::uint32_t>> bins_;  ///< triangles by where their bounds lie
  Vec3 low_, high_;
};

}  // namespace tandem::bench
