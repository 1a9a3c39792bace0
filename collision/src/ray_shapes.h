// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "convex_core.h"

namespace tandem::collision {

enum class RayResult : std::uint8_t { Miss, Hit, Inside };

/// The ray from the origin against a convex shape: closed forms for balls, capsules and boxes, a
/// cast of a point for all others. Shapes are closed: a ray within a face or along an edge hits.
/// @param direction  unit     @param limit  m
/// @param[out] distance  m, @param[out] normal  unit, outwards; both of a Hit only
RayResult ray_core(const ConvexCore& core, const Vec3& direction, double limit, double& distance,
                   Vec3& normal);

/// The ray from the origin against a triangle, from either side. Edges and corners count, so that
/// no ray slips between two triangles with a common edge. A ray within the plane misses.
bool ray_triangle(const std::array<Vec3, 3>& corners, const Vec3& normal, const Vec3& direction,
                  double limit, double& distance);

}  // namespace tandem::collision
