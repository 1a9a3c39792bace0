// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/types.h"

namespace tandem::detail {

using pbd::Vec3;

inline constexpr double kShortest = 1e-7;  ///< m: shorter paths count as 0

/// The part of v perpendicular to the unit vector `axis`.
inline Vec3 without(const Vec3& v, const Vec3& axis) { return v - v.dot(axis) * axis; }

/// The planes that a path has met so far.
class ClipPlanes {
 public:
  static constexpr int kMax = 5;

  /// Adds a plane. @return false if there is no room
  bool add(const Vec3& normal) {
    if (count_ == kMax) return false;
    normals_[count_++] = normal;
    return true;
  }
  /// Clips `way` to all planes, the last one first: along a plane, else along the crease of two,
  /// else 0. Never longer than before.
  Vec3 clip(const Vec3& way) const {
    const Vec3& last = normals_[count_ - 1];
    if (way.dot(last) >= 0.0) return way;
    Vec3 rest = without(way, last);
    for (int i = 0; i + 1 < count_; ++i) {
      if (rest.dot(normals_[i]) >= -kShortest * rest.norm()) continue;
      const Vec3 crease = normals_[i].cross(last);
      if (crease.norm() < 1e-6) return Vec3::Zero();
      rest = crease.normalized() * crease.normalized().dot(way);
      for (int k = 0; k + 1 < count_; ++k) {
        if (rest.dot(normals_[k]) < -kShortest) return Vec3::Zero();
      }
      return rest;
    }
    return rest;
  }

 private:
  std::array<Vec3, kMax> normals_;
  int count_ = 0;
};

}  // namespace tandem::detail
