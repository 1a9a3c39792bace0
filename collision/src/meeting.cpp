// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "meeting.h"

#include <cmath>

namespace tandem::collision {

ConvexCore moved_by(const ConvexCore& core, const Vec3& way) {
  ConvexCore moved = core;
  moved.centre += way;
  for (Vec3& corner : moved.corners) corner += way;
  return moved;
}

Vec3 until_meeting(const ConvexCore& a, const ConvexCore& b, const Vec3& way, double margin,
                   Direction& direction, std::size_t& queries) {
  if (direction.status != Direction::Status::Found) return Vec3::Zero();
  const auto approach = [&](const ConvexCore& there) {
    const Vec3& n = direction.normal;
    return Approach{n, separation(a, there, n) - a.radius - b.radius};
  };
  Vec3 moved = Vec3::Zero();
  const auto look = [&](double share) {
    ++queries;
    const ConvexCore there = moved_by(b, share * way);
    const Direction found = query_direction(a, there, margin);
    // Too near for the library: the last direction is the one in which they meet.
    if (found.status == Direction::Status::Unknown) return Approach{direction.normal, 0.0};
    moved = share * way;
    direction = found;
    const bool apart = found.status == Direction::Status::Apart;
    return apart ? Approach{found.normal, HUGE_VAL} : approach(there);
  };
  share_to_meeting(way, kMet * std::min(a.size, b.size), approach(b), look);
  return moved;
}

}  // namespace tandem::collision
