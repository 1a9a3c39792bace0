// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "convex_core.h"

namespace tandem::collision {

/// Relative position of two convex shapes, radii included.
struct Proximity {
  double gap = 0.0;             ///< m between the surfaces; negative where they overlap
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  Vec3 on_a = Vec3::Zero();     ///< m, on the surface of a; gap = normal . (on_b - on_a)
  Vec3 on_b = Vec3::Zero();     ///< m, on the surface of b
};

/// Distance of two cores, without their radii.
struct CoreDistance {
  bool apart = false;     ///< if false (touching), nothing below is set
  double distance = 0.0;  ///< m
  /// m, <= distance: room between the two planes perpendicular to `normal` that bound the cores.
  double least = 0.0;
  double size = 0.0;            ///< m, scale for rounding errors
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  Vec3 on_a = Vec3::Zero();     ///< m
  Vec3 on_b = Vec3::Zero();     ///< m
};

/// GJK on support points; any pair of kinds in any order. Exact to rounding for flat cores; cores
/// nearer than 1e-12 of their size touch. Allocates nothing.
/// Source: [ericson2005] Sec. 9.5; the nearest point of a simplex by Voronoi regions, Sec. 5.1.
CoreDistance core_distance(const ConvexCore& a, const ConvexCore& b);

/// Nearest points. For overlapping cores, the direction of (nearly) least depth, by choose_axis(),
/// and one of possibly many pairs of opposite points.
Proximity proximity(const ConvexCore& a, const ConvexCore& b);

/// A ball of radius 0.
ConvexCore point_core(const Vec3& position);

/// First contact of core a, moving along a line without turning, with core b. Conservative
/// advancement: if no plane closes in, there is no contact; else the distance to the plane is safe
/// to travel.
/// Source: [mirtich1996], without its rotation terms.
/// @param direction  unit     @param limit  m, >= 0
/// @param[out] travel  m, 0 if they overlap at the start     @param[out] at  there
/// @return whether they meet within the limit; false for shapes that touch while separating
bool cast_core(ConvexCore a, const ConvexCore& b, const Vec3& direction, double limit,
               double& travel, Proximity& at);

}  // namespace tandem::collision
