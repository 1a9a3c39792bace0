// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Basic quickhull: the farthest point outside is added next. With at most 128 corners, conflict
// lists are not worth their upkeep; faces are searched one by one. The side of a face is decided
// exactly, on an integer grid: otherwise faces would not close for points of single precision that
// nearly lie in planes and on lines. Neither FCL nor libccd nor Eigen builds hulls.
#include "quickhull.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "tandem/collision/convex_hull.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Vec3;

/// Steps of the grid in the extent: with more, the side of a plane would not fit 64 bits.
constexpr double kSteps = 1 << 20;
constexpr const char* kVolumeRule =
    "such that they span a volume (1e-4 of their extent in each direction)";

using GridPoint = std::array<std::int64_t, 3>;

/// A face's plane through grid points, exact.
struct GridPlane {
  GridPoint at;
  GridPoint normal;  ///< twice the area long, at most 2^41.8
  double length;     ///< of the normal
  std::uint32_t number;
  /// > 0 outside, in steps times `length`; below 2^63, like all partial sums.
  std::int64_t side(const GridPoint& p) const {
    std::int64_t sum = 0;
    for (int k = 0; k < 3; ++k) sum += normal[k] * (p[k] - at[k]);
    return sum;
  }
  double above(const GridPoint& p) const { return static_cast<double>(side(p)) / length; }
};

GridPlane grid_plane(std::span<const GridPoint> points, const HullTriangle& t,
                     std::uint32_t number) {
  GridPoint u;
  GridPoint v;
  for (int k = 0; k < 3; ++k) {
    u[k] = points[t[1]][k] - points[t[0]][k];
    v[k] = points[t[2]][k] - points[t[0]][k];
  }
  const GridPoint n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                    u[0] * v[1] - u[1] * v[0]};
  const Vec3 length(static_cast<double>(n[0]), static_cast<double>(n[1]),
                    static_cast<double>(n[2]));
  return {points[t[0]], n, length.norm(), number};
}

std::uint32_t furthest(std::size_t count, auto&& score) {
  std::uint32_t best = 0;
  double most = -HUGE_VAL;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double value = score(i);
    if (value <= most) continue;
    most = value;
    best = i;
  }
  return best;
}

}  // namespace

Tetrahedron large_tetrahedron(std::span<const Vec3> points, double extent) {
  const std::uint32_t a = furthest(points.size(), [&](std::uint32_t i) { return -points[i].x(); });
  const auto from_a = [&](std::uint32_t i) { return Vec3(points[i] - points[a]); };
  const std::uint32_t b =
      furthest(points.size(), [&](std::uint32_t i) { return from_a(i).squaredNorm(); });
  const Vec3 u = from_a(b).normalized();
  const std::uint32_t c =
      furthest(points.size(), [&](std::uint32_t i) { return u.cross(from_a(i)).squaredNorm(); });
  if (!(u.cross(from_a(c)).norm() > kFlatHull * extent))
    pbd::detail::refuse("ConvexHull: points", kVolumeRule, "on a line");
  const Vec3 n = u.cross(from_a(c)).normalized();
  const std::uint32_t d =
      furthest(points.size(), [&](std::uint32_t i) { return std::abs(n.dot(from_a(i))); });
  return {a, b, c, d, n, n.dot(from_a(d))};
}

namespace {

/// Its faces, fronts outwards.
std::vector<HullTriangle> first_tetrahedron(std::span<const Vec3> points, double extent) {
  const auto [a, b, c, d, normal, height] = large_tetrahedron(points, extent);
  if (!(std::abs(height) > kFlatHull * extent))
    pbd::detail::refuse("ConvexHull: points", kVolumeRule, "in a plane");
  if (height > 0.0) return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
  return {{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}};
}

using Edge = std::array<std::uint32_t, 2>;  // directed

struct Highest {
  double above = -std::numeric_limits<double>::infinity();
  std::uint32_t plane = 0;  ///< index
};
bool is_lower(const Highest& l, const Highest& r) { return l.above < r.above; }

/// Height above the hull from which on a point becomes a corner, m: at least a step.
/// @param tolerance  share of the height of the first tetrahedron: see ConvexHull::make()
double least_above(std::span<const Vec3> points, const std::vector<HullTriangle>& tetrahedron,
                   double step, double tolerance) {
  const HullPlane base = hull_plane(points, tetrahedron[0]);
  double height = 0.0;
  for (const std::uint32_t v : tetrahedron[1]) height = std::max(height, -base.above(points[v]));
  return std::max(step, tolerance * height);
}

void check_rounds(std::size_t round) {
  // A new corner may be covered later, but that cannot happen to so many.
  if (round <= 2 * ConvexHull::kMaxVertices) return;
  pbd::detail::refuse("ConvexHull: corners", "at most 128", "more");
}

/// By Euler's formula a closed triangle surface has twice as many triangles as corners, minus four.
bool is_full(std::span<const HullTriangle> faces) {
  return faces.size() + 4 >= std::size_t{2} * ConvexHull::kMaxVertices;
}

std::vector<GridPoint> to_grid(std::span<const Vec3> points, double step) {
  std::vector<GridPoint> out;
  out.reserve(points.size());
  for (const Vec3& p : points) {
    out.push_back(
        {std::llround(p.x() / step), std::llround(p.y() / step), std::llround(p.z() / step)});
  }
  return out;
}

}  // namespace

Quickhull quickhull(std::span<const Vec3> points, double extent, double tolerance, bool cut) {
  std::vector<HullTriangle> faces = first_tetrahedron(points, extent);
  const double step = extent / kSteps;
  const double least = least_above(points, faces, step, tolerance) / step;
  const std::vector<GridPoint> grid = to_grid(points, step);
  std::vector<GridPlane> planes;
  std::uint32_t planes_made = 0;
  const auto plane_of = [&](const HullTriangle& t) { return grid_plane(grid, t, planes_made++); };
  std::transform(faces.begin(), faces.end(), std::back_inserter(planes), plane_of);
  // For each point the plane that it is farthest above, or least below.
  std::vector<Highest> highest(points.size());
  const auto look = [&](std::uint32_t i, std::span<const GridPlane> at) {
    for (const GridPlane& plane : at) {
      const double above = plane.above(grid[i]);
      if (above > highest[i].above) highest[i] = {above, plane.number};
    }
  };
  for (std::uint32_t i = 0; i < points.size(); ++i) look(i, planes);
  std::vector<HullTriangle> kept;
  std::vector<GridPlane> kept_planes;
  std::vector<bool> gone;  // planes, by number
  std::vector<Edge> seen;  // of the faces that see the point
  for (std::size_t round = 0; round <= points.size(); ++round) {
    if (!cut) check_rounds(round);
    const auto next = static_cast<std::uint32_t>(
        std::max_element(highest.begin(), highest.end(), is_lower) - highest.begin());
    const double above = highest[next].above;
    if (!(above > least) || (cut && is_full(faces))) return {faces, std::max(above, 0.0) * step};
    kept.clear();
    kept_planes.clear();
    seen.clear();
    gone.assign(planes_made, false);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      // Faces coplanar with the point are removed too, so that no sliver is left beside them.
      if (planes[f].side(grid[next]) >= 0) {
        for (int k = 0; k < 3; ++k) seen.push_back({faces[f][k], faces[f][(k + 1) % 3]});
        gone[planes[f].number] = true;
      } else {
        kept.push_back(faces[f]);
        kept_planes.push_back(planes[f]);
      }
    }
    const std::size_t stay = kept.size();
    for (const Edge& edge : seen) {
      if (std::find(seen.begin(), seen.end(), Edge{edge[1], edge[0]}) != seen.end())
        continue;  // interior of the removed region
      kept.push_back({edge[0], edge[1], next});
      kept_planes.push_back(plane_of(kept.back()));
    }
    faces.swap(kept);
    planes.swap(kept_planes);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const bool lost = gone[highest[i].plane];
      if (lost) highest[i] = {};
      look(i, std::span(planes).subspan(lost ? 0 : stay));
    }
  }
  return {faces, 0.0};
}

}  // namespace tandem::collision
