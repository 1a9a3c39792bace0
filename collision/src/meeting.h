// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>

#include "fcl_bridge.h"

namespace tandem::collision {

/// Relative position of two separated shapes.
struct Approach {
  pbd::Vec3 normal;  ///< unit, from a to b
  double gap = 0.0;  ///< m, along it
};

/// Contacts of separated shapes take the direction in which they will meet: with the current
/// direction, a shape passing by an edge would be thrown off it. The distance of two convex shapes
/// that move on straight lines is a convex function, so Newton's method finds its zero from below,
/// within a few iterations.
/// @param sweep   m, motion of b relative to a within the step
/// @param near    m, gap at which they count as met
/// @param gap     m, current gap along `normal`
/// @param look    look(share) is the Approach with b moved by that share of the sweep
/// @return the share of the sweep after which they meet, or at which the direction shows that they
///   do not meet within the step; 0 if they have met now
template <class Look>
double share_to_meeting(const pbd::Vec3& sweep, double near, Approach at, Look&& look) {
  constexpr int kLooks = 8;
  double share = 0.0;
  for (int i = 0; i < kLooks && at.gap > near; ++i) {
    const double closing = -at.normal.dot(sweep);
    if (closing * (1.0 - share) <= at.gap) break;
    share += (at.gap - 0.5 * near) / closing;
    at = look(share);
  }
  return share;
}

/// Share of the smaller size at which two shapes have met: above the library's rounding.
inline constexpr double kMet = 1e-4;

/// The core, displaced.
ConvexCore moved_by(const ConvexCore& core, const Vec3& way);

/// Displacement of b along the way (m) after which the two are positioned as when they meet.
/// @param direction  current direction of b; set to the direction there
/// @param queries    increased by the number of library queries
Vec3 until_meeting(const ConvexCore& a, const ConvexCore& b, const Vec3& way, double margin,
                   Direction& direction, std::size_t& queries);

}  // namespace tandem::collision
