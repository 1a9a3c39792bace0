// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "clipping.h"
#include "convex_core.h"
#include "fcl_bridge.h"

namespace tandem::collision {

/// Range within which a contact matters.
struct Reach {
  double margin = 0.0;         ///< m, largest gap
  Vec3 sweep = Vec3::Zero();   ///< m, motion of b relative to a within the step
  Vec3 way = Vec3::Zero();     ///< m, the part that counts for meeting: see PairReach
  Vec3 weight = Vec3::Zero();  ///< m, centre of mass of the upper body
};

/// The direction of a contact and the face that it is normal to.
struct ContactAxis {
  Vec3 normal = Vec3::UnitZ();        ///< unit, from a to b
  double separation = 0.0;            ///< m, of the cores along it
  FaceOwner owner = FaceOwner::None;  ///< whose face it is normal to
};

/// Turns the library's direction into the contact's. Face normals that separate (nearly) as well
/// are preferred, because a face gives a wide manifold and does not flicker; a direction between
/// two edges is made exact. If the direction is unknown, all face normals and edge products are
/// searched (overlapping cores: see fcl_bridge.cpp), and with curved sides the neighbourhood of the
/// best.
/// @param hint  the last step's normal, or null: shapes with many edges are searched around it
/// @param ground  whose faces are preferred among those that separate about as well: a body on
///   several tiles, tilted by rounding, is supported along the one normal of all tiles. A hull that
///   slid over ten tiles along its own face sped up by 4 %.
ContactAxis choose_axis(const ConvexCore& a, const ConvexCore& b, const Direction& direction,
                        const Vec3* hint = nullptr, FaceOwner ground = FaceOwner::None);

/// The axis across the front of triangle b alone.
ContactAxis front_axis(const ConvexCore& a, const ConvexCore& b);

/// Points of the contact along the axis: features clipped against each other, at most four with a
/// gap below the margin (the caller's reduce() handles more). No points: no contact.
RawManifold build_manifold(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                           const Reach& reach);

/// Points of the contact with the half-space normal . x <= offset as b.
RawManifold half_space_manifold(const ConvexCore& a, const Vec3& normal, double offset,
                                double margin);

}  // namespace tandem::collision
