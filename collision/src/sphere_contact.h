// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "collider.h"

namespace tandem::collision {

/// Contact of a sphere with a shape, relative to the sphere's centre, in the world's axes.
struct SphereContact {
  Vec3 normal = Vec3::UnitZ();  ///< unit, from the sphere to the shape
  Vec3 on_b = Vec3::Zero();     ///< m, on the shape's core
  double distance = 0.0;        ///< m, along the normal to on_b; negative inside
  double radius_b = 0.0;        ///< m, of the shape around its core
};

/// Whether sphere_contact() knows the kind.
inline bool has_sphere_contact(Kind kind) {
  return (kind < Kind::Triangles && kind != Kind::Polytope) || kind == Kind::HalfSpace;
}

/// Whether two spheres are too far apart for a contact within the step, in any direction of motion.
inline bool spheres_apart(const Collider& a, const Collider& b) {
  const double reach = 0.5 * (a.size + b.size) +
                       std::min(a.margins.speculative, b.margins.speculative) +
                       (a.motion().travel + b.motion().travel);
  constexpr double kRounding = 1.0 + 1e-12;
  return (b.position - a.position).squaredNorm() > kRounding * (reach * reach);
}

/// Closed forms for a sphere at `centre` (m, world). The collision library has the same ones for
/// spheres, capsules, boxes and half-spaces, with the same results (0.08 to 0.12 us, one or two
/// allocations a query); these cost a fifth and allocate nothing, so spheres need no cache.
/// @pre has_sphere_contact(b.kind)
SphereContact sphere_contact(const Vec3& centre, const Collider& b);

/// Point of the triangle nearest to p. Source: [ericson2005] Sec. 5.1.5.
/// @param region  set to 3 inside, k on edge k (corner k to k + 1), 4 + k at corner k
Vec3 nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& region);

}  // namespace tandem::collision
