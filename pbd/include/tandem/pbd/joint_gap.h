// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::pbd {

/// Violation of a joint that came from outside the solver: it was added violated, a body was placed
/// or limits changed. It closes by displacement, which gives no velocity (docs/ARCHITECTURE.md).
/// Saved with the joint.
struct JointGap {
  /// m or rad: an increase over the last step's residual by less than this is rounding. A gap
  /// smaller than this is closed.
  static constexpr double kTolerance = 1e-9;

  double least = 0.0;         ///< m or rad, its minimum so far; 0 = closed
  std::uint32_t stalled = 0;  ///< steps since that minimum

  bool is_open() const { return least > 0.0; }
  /// Joints whose gaps cannot close, because they contradict each other, may rest after so many
  /// steps.
  bool closes() const { return is_open() && stalled < 60; }
  void open(double size) {
    if (size > least) *this = {.least = size};
  }
  /// Updates after a step. @param size  remaining gap
  void settle(double size) {
    if (!is_open()) return;
    ++stalled;
    if (!(size > kTolerance)) *this = {};
    if (size < least) *this = {.least = size};
  }
};

}  // namespace tandem::pbd
