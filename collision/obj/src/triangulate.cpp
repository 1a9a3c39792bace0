// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "triangulate.h"

#include <cmath>
#include <cstddef>

namespace tandem::obj {
namespace {

using pbd::Vec3;

/// Twice the area of a triangle over the square of its longest edge, below which it is degenerate.
constexpr double kFlat = 1e-9;

struct Corners {
  Vec3 a, b, c;
};

/// Whether the triangle turns left seen from the tip of the unit vector n.
bool turns_left(const Corners& t, const Vec3& n) {
  const double area2 = n.dot((t.b - t.a).cross(t.c - t.b));
  const double longest2 =
      std::max({(t.b - t.a).squaredNorm(), (t.c - t.b).squaredNorm(), (t.a - t.c).squaredNorm()});
  return area2 > kFlat * longest2;
}

/// Whether the point is in the triangle or on its border.
bool holds(const Corners& t, const Vec3& n, const Vec3& p) {
  const double slop = -kFlat * (t.c - t.a).squaredNorm();
  return n.dot((t.b - t.a).cross(p - t.a)) >= slop && n.dot((t.c - t.b).cross(p - t.b)) >= slop &&
         n.dot((t.a - t.c).cross(p - t.c)) >= slop;
}

}  // namespace

bool triangulate(std::span<const Vec3> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<collision::TriangleMesh::Triangle>& out) {
  std::vector<std::uint32_t> rest(polygon.begin(), polygon.end());
  // The normal as a sum over edges, which concave corners do not flip.
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec3& first = vertices[rest[0]];
    normal += (vertices[rest[i]] - first).cross(vertices[rest[(i + 1) % rest.size()]] - first);
  }
  const double length = normal.norm();
  if (!(length > 0.0)) return false;
  normal /= length;

  while (rest.size() >= 3) {
    const std::size_t n = rest.size();
    std::size_t best = n;
    double shortest = HUGE_VAL;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = (i + n - 1) % n;
      const std::size_t after = (i + 1) % n;
      const Corners ear{vertices[rest[before]], vertices[rest[i]], vertices[rest[after]]};
      const double cut = (ear.c - ear.a).squaredNorm();
      if (cut >= shortest || !turns_left(ear, normal)) continue;
      bool free = true;
      for (std::size_t k = 0; k < n && free; ++k) {
        const Vec3& p = vertices[rest[k]];
        const bool corner = p == ear.a || p == ear.b || p == ear.c;
        free = corner || !holds(ear, normal, p);
      }
      if (!free) continue;
      best = i;
      shortest = cut;
    }
    if (best == n) return false;
    out.push_back({rest[(best + n - 1) % n], rest[best], rest[(best + 1) % n]});
    if (n == 3) return true;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return false;
}

}  // namespace tandem::obj
