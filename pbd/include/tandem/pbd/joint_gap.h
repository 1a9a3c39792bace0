// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>

namespace tandem::pbd {

/// Violation of a joint that came from outside the solver: it was added violated, a body was placed
/// or limits changed. It closes by displacement, which gives no velocity (docs/ARCHITECTURE.md).
/// Saved with the joint.
struct JointGap {
  /// m or rad: an increase over the last step's residual by less than this is rounding.
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
  /// Updates after a step.
  /// @param size  remaining violation, m or rad
  /// @param tolerance  m or rad, the accuracy of joints: a smaller gap is closed
  /// @param pressed  contacts act on the joint's ends. They may be all that the gap waits for, and
  ///   would open it again: it is closed without a remainder only.
  void settle(double size, double tolerance, bool pressed) {
    if (!is_open()) return;
    ++stalled;
    if (!(size > (pressed ? kTolerance : std::max(kTolerance, tolerance)))) *this = {};
    if (size < least) *this = {.least = size};
  }
};

}  // namespace tandem::pbd
