// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <stdexcept>
#include <string>

#include "grouped_warnings.h"
#include "tandem/collision/convex_hull.h"

namespace tandem::scene_files {

inline constexpr const char* kNearestHull =
    "its hull has more than 128 corners, or is flat: it has the nearest one";

/// The hull of a file's points, or the nearest valid one.
/// @param strict  other hulls than the points' own are an error
/// @param tell  called with the error of the nearest one, as "(by 0.3 mm)"
/// @throws std::invalid_argument
inline collision::Hull nearest_hull(std::span<const Vec3> points, bool strict, auto&& tell) {
  try {
    return collision::ConvexHull::make(points);
  } catch (const std::invalid_argument&) {
    if (strict) throw;
    const auto [hull, error] = collision::ConvexHull::simplify(points);
    tell("(by " + short_number(1e3 * error) + " mm)");
    return hull;
  }
}

}  // namespace tandem::scene_files
