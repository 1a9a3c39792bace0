// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

namespace tandem::demos {

/// Recent quantiles of positive numbers, to 4 %, in bounded memory: over the last one to two
/// periods, which turn() begins.
/// @par Thread safety  Distinct objects: safe.
class RecentQuantiles {
 public:
  static constexpr double kMin = 1e-7;    ///< smaller values count as this
  static constexpr double kRatio = 1.08;  ///< between bins; the last one is at 33

  /// NaN is skipped.
  void add(double value);
  void turn();
  /// @param q  0 to 1. Returns 0 without values
  double quantile(double q) const;

  // Since the start.
  std::uint64_t count() const { return count_; }
  double sum() const { return sum_; }

 private:
  static constexpr std::size_t kBins = 256;
  using Bins = std::array<std::uint32_t, kBins>;

  Bins now_{};
  Bins before_{};
  std::uint64_t count_ = 0;
  double sum_ = 0.0;
};

}  // namespace tandem::demos
