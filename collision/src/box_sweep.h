// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/collision/triangle_mesh.h"

namespace tandem::collision {

/// A moving box, for searches in trees of boxes. Conservative: rounding never hides a box that is
/// met.
class BoxSweep {
 public:
  /// @param direction  unit, or zero for a box at rest
  BoxSweep(const Aabb& box, const pbd::Vec3& direction)
      : start_(0.5 * (box.min + box.max)),
        half_(0.5 * (box.max - box.min)),
        direction_(direction),
        inverse_(direction.cwiseInverse()) {}

  /// Distance until it meets `box`, m; infinite if not within `limit`.
  double rank(const Aabb& box, double limit) const {
    double from = 0.0;
    double to = limit;
    for (int k = 0; k < 3; ++k) {
      const double size =
          std::abs(start_[k]) + std::abs(box.min[k]) + std::abs(box.max[k]) + half_[k] + limit;
      const double grown = half_[k] + 1e-14 * size;
      const double low = box.min[k] - grown - start_[k];
      const double high = box.max[k] + grown - start_[k];
      if (std::abs(direction_[k]) < 1e-100) {
        if (low > 0.0 || high < 0.0) return HUGE_VAL;
        continue;
      }
      const double t0 = low * inverse_[k];
      const double t1 = high * inverse_[k];
      from = std::max(from, std::min(t0, t1));
      to = std::min(to, std::max(t0, t1));
      if (from > to) return HUGE_VAL;
    }
    return from;
  }

  /// Whether the second of two boxes is nearer to the start.
  bool second_first(const Aabb& first, const Aabb& second) const {
    const pbd::Vec3 between = (second.min + second.max) - (first.min + first.max);
    return direction_.dot(between) < 0.0;
  }

 private:
  pbd::Vec3 start_;
  pbd::Vec3 half_;
  pbd::Vec3 direction_;
  pbd::Vec3 inverse_;
};

}  // namespace tandem::collision
