// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/pbd/math.h"

namespace tandem::bench {

/// The generator used to measure other engines: do not change it.
class SceneRandom {
 public:
  /// Uniform in [0, 1).
  double u() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state_ >> 33) / 2147483648.0;
  }
  /// About an axis drawn by rejection from a cube, by an angle in [0, largest_angle) rad.
  pbd::Quat orientation(double largest_angle) {
    for (;;) {
      const double x = 2.0 * u() - 1.0;
      const double y = 2.0 * u() - 1.0;
      const double z = 2.0 * u() - 1.0;
      const pbd::Vec3 axis(x, y, z);
      const double norm2 = axis.squaredNorm();
      if (norm2 < 1e-3 || norm2 > 1.0) continue;
      return pbd::exp_map(axis.normalized() * (largest_angle * u()));
    }
  }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15ull;
};

}  // namespace tandem::bench
