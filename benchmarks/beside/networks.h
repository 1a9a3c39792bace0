// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tandem::beside_bench {

/// What becomes of a demo where the second of four peers has a bad network, or a bad machine.
struct Troubled {
  std::string scene;
  std::string trouble;
  double others = 0.0;  ///< m, p95 of what moves without his hand, among the other three
  double together =
      0.0;               ///< s after the trouble, until all four are together again; < 0: not asked
  double at_rest = 0.0;  ///< s, the same of what rests
  double gap = 0.0;      ///< m, the largest in the trouble
  double leap = 0.0;     ///< m, by which a copy of his was moved further at once than it was off
};

/// s: the trouble lasts from kFrom to kTo.
inline constexpr double kFrom = 2.0;
inline constexpr double kTo = 8.0;
inline constexpr double kEnd = 12.0;

/// The first is without any.
std::vector<Troubled> troubled(const std::string& scene, std::uint64_t seed);

}  // namespace tandem::beside_bench
