// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scenario.h"
#include "scenes/scene.h"
#include "tandem/pbd/types.h"

namespace tandem::demos {

/// Penetration depth of two sharp boxes (m): the least separating translation along one of the 15
/// axes of the separating-axis theorem; 0 without overlap. Independent of the engine's own
/// contacts.
double box_overlap(const pbd::Pose& a, const pbd::Vec3& half_a, const pbd::Pose& b,
                   const pbd::Vec3& half_b);

/// Penetration depth of a ball in a box (m), along the shortest way out; 0 if there is none.
double ball_box_overlap(const pbd::Vec3& centre, double radius, const pbd::Pose& box,
                        const pbd::Vec3& half);

/// Depth of a box's lowest corner below the ground, z = 0 (m); 0 above it.
double ground_overlap(const pbd::Pose& pose, const pbd::Vec3& half);

/// Appends the depth of every overlap of bodies with each other and with fixed parts. Covers boxes,
/// balls and the half-space z <= 0; other shapes are skipped.
void append_penetrations(const Scene& scene, std::vector<double>& out);

/// The first body out of bounds, and how; empty if there is none.
std::string out_of_bounds(const Scene& scene, const Bounds& bounds);

/// Steps between checks of penetration and Scenario::fault.
inline constexpr std::uint64_t kLookEvery = 5;

}  // namespace tandem::demos
