// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <vector>

#include "collider.h"

namespace tandem::collision {

/// Share of the collider's least extent: a body that rests or is pushed into something never sinks
/// so deep that its core touches.
inline constexpr double kCoreShare = 0.25;

/// m: radius of the ball in the middle of a collider that must not tunnel.
inline double core_radius(const Collider& c) { return kCoreShare * c.size; }
/// m, world: centre of that ball for a body at `body`, for any local pose.
Vec3 placed_core_centre(const Collider& c, const pbd::Pose& body);
/// m, world: the same, with a fast path for a shape in the body's frame.
inline Vec3 core_centre(const Collider& c, const pbd::Pose& body) {
  return c.local_identity && c.kind != Kind::Polytope ? body.position : placed_core_centre(c, body);
}

inline bool lies_before(const Vec3& l, const Vec3& r) {
  return std::lexicographical_compare(l.data(), l.data() + 3, r.data(), r.data() + 3);
}

struct CoreHit {
  double share = 1.0;
  Vec3 normal = Vec3::UnitZ();  ///< unit, world, out of the target
  Vec3 moved = Vec3::Zero();    ///< m, motion of the target, which carries along what it meets

  /// Keeps the earlier hit; ties do not depend on the order.
  void take_first(const CoreHit& other) {
    if (other.share < share || (other.share == share && lies_before(other.normal, normal))) {
      *this = other;
    }
  }
};

/// Share of the path from `from` to `to` (m, world) that a ball may go until it touches `target` at
/// its current pose; 1 if it does not. A ball that starts nearer than its radius counts as half as
/// near, so that its centre stays outside; one that starts inside is not stopped. Conservative
/// advancement: for convex targets the distance is a convex function of time, so that Newton's
/// steps never overshoot. A surface stops centres that come from its front.
/// @param list  scratch
CoreHit core_cast(const Vec3& from, const Vec3& to, double radius, const Collider& target,
                  std::vector<std::uint32_t>& list);

}  // namespace tandem::collision
