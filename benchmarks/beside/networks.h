// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tandem::beside_bench {

/// A demo in which the second of four peers has a bad network or a bad machine.
struct Troubled {
  std::string scene;
  std::string trouble;
  double others = 0.0;    ///< m, p95 of bodies it does not move, other peers
  double together = 0.0;  ///< s from then until all agree; < 0: not measured
  double at_rest = 0.0;   ///< s, the same for bodies at rest
  double gap = 0.0;       ///< m, maximum during the trouble
  double leap = 0.0;      ///< m, largest shift of its copies at once, beyond their error
};

/// s: begin and end of the trouble.
inline constexpr double kFrom = 2.0;
inline constexpr double kTo = 8.0;
inline constexpr double kEnd = 12.0;

/// The first one is without trouble.
std::vector<Troubled> troubled(const std::string& scene, std::uint64_t seed);

}  // namespace tandem::beside_bench
