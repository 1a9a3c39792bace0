// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "clipping.h"
#include "convex_core.h"
#include "fcl_bridge.h"

namespace tandem::collision {

/// How far a contact may be away to be of interest.
struct Reach {
  double margin = 0.0;         ///< m, largest gap
  Vec3 sweep = Vec3::Zero();   ///< m, motion of b against a within the step
  Vec3 way = Vec3::Zero();     ///< m, that of it which counts for meeting: see PairReach
  Vec3 weight = Vec3::Zero();  ///< m, centre of mass of the body that lies on the other
};

/// The direction of a contact and what it is normal to.
struct ContactAxis {
  Vec3 normal = Vec3::UnitZ();        ///< unit, from a to b
  double separation = 0.0;            ///< m, of the cores along it
  FaceOwner owner = FaceOwner::None;  ///< whose face it is normal to
};

/// From the library's direction to the contact's: face normals that separate (nearly) as well are
/// taken in its place, because a face gives a wide manifold and does not flicker; a direction
/// between two edges is made exact. Where the direction is unknown all face normals and edge
/// products are searched (overlapping cores: see fcl_bridge.cpp), and from the best of them the
/// neighbourhood where a side is curved.
/// @param hint  the last step's normal, or null: shapes with many edges are then searched around it
/// @param ground  whose faces count first among those that separate about as well: what lies on
///   several tiles, tilted by rounding, is borne along the one normal of all of them. A hull that
///   slid over ten tiles along its own face went faster by 4 %.
ContactAxis choose_axis(const ConvexCore& a, const ConvexCore& b, const Direction& direction,
                        const Vec3* hint = nullptr, FaceOwner ground = FaceOwner::None);

/// The axis across the given face of a triangle b alone.
ContactAxis front_axis(const ConvexCore& a, const ConvexCore& b);

/// Points of the contact along the axis: features clipped against each other, at most four with a
/// gap below the margin (more than four are left to the caller's reduce()). None: no contact.
RawManifold build_manifold(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                           const Reach& reach);

/// Points of the contact with the half-space normal . x <= offset as b.
RawManifold half_space_manifold(const ConvexCore& a, const Vec3& normal, double offset,
                                double margin);

}  // namespace tandem::collision
