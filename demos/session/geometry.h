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

/// How deep two sharp boxes overlap (m): the least translation along one of the 15 axes of the
/// separating-axis theorem that parts them; 0 where they do not overlap. Independent of the
/// engine's own contacts.
double box_overlap(const pbd::Pose& a, const pbd::Vec3& half_a, const pbd::Pose& b,
                   const pbd::Vec3& half_b);

/// How deep a ball overlaps a box (m), along the shortest way out; 0 where it does not.
double ball_box_overlap(const pbd::Vec3& centre, double radius, const pbd::Pose& box,
                        const pbd::Vec3& half);

/// How deep the lowest corner of a box is below the ground, z = 0 (m); 0 where it is above.
double ground_overlap(const pbd::Pose& pose, const pbd::Vec3& half);

/// Append the depth of every pair of bodies, and of every body and what is fixed, that overlap.
/// Boxes, balls and half-spaces under z = 0 are looked at; other shapes are passed over.
void append_penetrations(const Scene& scene, std::vector<double>& out);

/// The first body that is where it must never be, and how; empty where all are within.
std::string out_of_bounds(const Scene& scene, const Bounds& bounds);

/// Steps between two looks at penetration and at Scenario::fault.
inline constexpr std::uint64_t kLookEvery = 5;

}  // namespace tandem::demos
