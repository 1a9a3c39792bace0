// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <random>

#include "tandem/pbd/types.h"

namespace tandem::consensus::testing {

/// Seeded numbers, the same with every standard library.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t bits() { return engine_(); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits() % count); }
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  pbd::Vec3 vec3(double limit) {
    const double x = uniform(-limit, limit);
    const double y = uniform(-limit, limit);
    const double z = uniform(-limit, limit);
    return {x, y, z};
  }
  pbd::Vec3 direction() {
    for (;;) {
      const pbd::Vec3 v = vec3(1.0);
      if (v.norm() > 0.1 && v.norm() <= 1.0) return v.normalized();
    }
  }
  pbd::Quat rotation(double max_angle) {
    const pbd::Vec3 axis = direction();
    const double angle = uniform(0.0, max_angle);
    return pbd::Quat(Eigen::AngleAxisd(angle, axis));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace tandem::consensus::testing
