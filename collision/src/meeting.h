// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>

#include "fcl_bridge.h"

namespace tandem::collision {

/// How two shapes lie that are apart.
struct Approach {
  pbd::Vec3 normal;  ///< unit, from a to b
  double gap = 0.0;  ///< m, along it
};

/// A contact of shapes that are still apart takes the direction in which they will meet: in that of
/// where they are now, what passes by an edge would be thrown off it. The distance of two convex
/// shapes that move on straight lines is a convex function, so that Newton's method finds where it
/// becomes 0 from below, within a few looks.
/// @param sweep   m, motion of b against a within the step
/// @param near    m, so far apart they have met
/// @param gap     m, of now, and `normal` with it
/// @param look    look(share) is the Approach with b moved by that share of the sweep
/// @return the share of the sweep after which they meet, or after which the direction is one in
/// which
///   they do not within the step; 0 where they are as near now
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

/// Share of the smaller one's size at which two shapes have met: beyond the library's rounding.
inline constexpr double kMet = 1e-4;

/// The core at another place.
ConvexCore moved_by(const ConvexCore& core, const Vec3& way);

/// How far b has to be moved along the way (m) for the two to lie as they will where they meet.
/// @param direction  in which b lies now; becomes that in which it lies there
/// @param queries    raised by those that it takes
Vec3 until_meeting(const ConvexCore& a, const ConvexCore& b, const Vec3& way, double margin,
                   Direction& direction, std::size_t& queries);

}  // namespace tandem::collision
