// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::pbd {

/// Violation of a joint that came from outside the solver: it was added violated, a body was placed
/// or limits changed. It closes by displacement, which gives no velocity (docs/ARCHITECTURE.md).
/// Saved with the joint.
struct JointGap {
  /// m or rad: an increase over the last step's residual by less than this is rounding.
  static constexpr double kTolerance = 1e-9;
  /// A gap that has been closed for so many steps is over. Dolls that tumble on the ground are
  /// pushed off their joints in most steps: of twelve that fall 20 m (scene `rain`) the joints are
  /// open by 0.45 mm at p99, and by 2.4 mm if a gap is over in the step in which it closes.
  static constexpr std::uint32_t kClosed = 10;

  double least = 0.0;         ///< m or rad, its minimum so far; 0 = closed
  std::uint32_t stalled = 0;  ///< steps since that minimum
  std::uint32_t closed = 0;   ///< steps in a row in which no more than the tolerance was left

  bool is_open() const { return least > 0.0; }
  /// Joints whose gaps cannot close, because they contradict each other, may rest after so many
  /// steps.
  bool closes() const { return is_open() && stalled < 60; }
  void open(double size) {
    if (size > least) *this = {.least = size};
  }
  /// Updates after a step.
  /// @param size  remaining violation, m or rad
  /// @param tolerance  m or rad, the accuracy of the solver: it closes no gap further than that
  void settle(double size, double tolerance) {
    if (!is_open()) return;
    ++stalled;
    closed = size > tolerance ? 0 : closed + 1;
    if (closed > kClosed) {
      *this = {};
    } else if (size > tolerance && size < least) {
      *this = {.least = size};
    }
  }
};

}  // namespace tandem::pbd
