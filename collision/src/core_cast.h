// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <vector>

#include "collider.h"

namespace tandem::collision {

/// Of the collider's least extent: a body that rests or is pushed into something never comes so
/// far that its core touches.
inline constexpr double kCoreShare = 0.25;

/// m: radius of the ball in the middle of a collider that must not get through anything.
inline double core_radius(const Collider& c) { return kCoreShare * c.size; }
/// m, world: where that ball is when the body is at `body`; of what lies anyhow in it.
Vec3 placed_core_centre(const Collider& c, const pbd::Pose& body);
/// The same. Most lie as their body does.
inline Vec3 core_centre(const Collider& c, const pbd::Pose& body) {
  return c.local_identity && c.kind != Kind::Polytope ? body.position : placed_core_centre(c, body);
}

inline bool lies_before(const Vec3& l, const Vec3& r) {
  return std::lexicographical_compare(l.data(), l.data() + 3, r.data(), r.data() + 3);
}

struct CoreHit {
  double share = 1.0;
  Vec3 normal = Vec3::UnitZ();  ///< unit, world, out of the target
  Vec3 moved = Vec3::Zero();    ///< m, how far the target moves and takes along what it meets

  /// Of two at once the one that does not depend on who came first.
  void take_first(const CoreHit& other) {
    if (other.share < share || (other.share == share && lies_before(other.normal, normal))) {
      *this = other;
    }
  }
};

/// Share of the way from `from` to `to` (m, world) that a ball may go until it touches `target` as
/// it stands; 1 where it does not. A ball that starts nearer than its radius is taken as half that
/// near, so that its centre stays outside; one that starts inside is let go. Conservative
/// advancement; on convex targets the distance is a convex function of time, so that Newton's
/// steps never go too far. A surface stops centres that come from its front.
/// @param list  scratch
CoreHit core_cast(const Vec3& from, const Vec3& to, double radius, const Collider& target,
                  std::vector<std::uint32_t>& list);

}  // namespace tandem::collision
