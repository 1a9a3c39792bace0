// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "collider.h"
#include "gjk.h"

namespace tandem::collision {

// Rays and convex probes against one collider at its current pose. All positions are relative to
// `origin` (world), which the caller puts near the query to keep precision far out. Nothing here
// allocates. A new kind of shape needs a case in ray_collider() and in the walk over pieces
// (collider_query.cpp).

/// A point on a collider's surface.
struct SurfaceHit {
  double distance = 0.0;         ///< m: travelled until the hit; for nearest(): the gap
  double depth = 0.0;            ///< m, > 0 if the query began inside
  Vec3 normal = Vec3::UnitZ();   ///< unit, out of the collider
  Vec3 point = Vec3::Zero();     ///< m, on the collider
  Vec3 on_probe = Vec3::Zero();  ///< m
  std::uint32_t triangle = TriangleMesh::kNone;
};

/// Which sides of triangles stop rays and casts.
enum class MeshSides : std::uint8_t { Front, Both };

/// The ray from `origin`.
/// @param direction  unit     @param limit  m
/// @return whether it hits the collider within the limit; true if it starts in a solid
bool ray_collider(const Collider& collider, const Vec3& origin, const Vec3& direction, double limit,
                  MeshSides sides, SurfaceHit& out);

/// Moves the probe along `direction` (unit) by at most `limit` (m).
bool cast_collider(const Collider& collider, const ConvexCore& probe, const Vec3& origin,
                   const Vec3& direction, double limit, MeshSides sides, SurfaceHit& out);

/// Whether the two share a point; the inside of a closed mesh counts.
bool overlaps_collider(const Collider& collider, const ConvexCore& probe, const Vec3& origin);

/// Nearest point within `limit` (m) of the probe; a mesh counts as its surface.
bool nearest_on_collider(const Collider& collider, const ConvexCore& probe, const Vec3& origin,
                         double limit, SurfaceHit& out);

/// Whether two colliders share a point. False for two meshes and for two half-spaces.
bool colliders_overlap(const Collider& a, const Collider& b);

/// Bounds of a core with its radius.
Aabb bounds_of(const ConvexCore& core);

}  // namespace tandem::collision
