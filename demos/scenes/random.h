// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::demos {

/// SplitMix64: the same numbers on every machine, unlike the standard library's distributions.
/// @par Thread safety  Distinct objects: safe.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  /// Uniform in [low, high).
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1.0p-53);
  }
  /// Uniform in [0, count), count > 0; the bias is below count / 2^64.
  std::uint64_t below(std::uint64_t count) { return next() % count; }

 private:
  std::uint64_t state_;
};

/// A seed of its own for each use of one seed: `stream` tells the uses apart.
inline std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t stream) {
  return Random(seed * 0x2545f4914f6cdd1dull + stream).next();
}

}  // namespace tandem::demos
