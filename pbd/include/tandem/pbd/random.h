// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// The generator SplitMix64: the same numbers on every machine, unlike the standard library's
/// distributions. For simulations and tests; not for secrets.
/// @par Thread safety  Distinct objects: safe.
class TANDEM_API SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// Uniform in [0, 1), 53 bits.
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// Uniform in [0, count), count > 0; the bias is below count / 2^64.
  std::uint64_t below(std::uint64_t count) { return next() % count; }
  /// True with that probability.
  bool chance(double probability) { return unit() < probability; }

 private:
  std::uint64_t state_;
};

}  // namespace tandem::pbd
