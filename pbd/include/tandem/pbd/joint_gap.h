// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::pbd {

/// What a joint violates since somebody added it, put one of its bodies elsewhere or changed its
/// limits. It closes by displacement, which gives no velocity (docs/ARCHITECTURE.md). Saved with
/// the joint.
struct JointGap {
  /// More than this (m or rad) beyond what the last step left is no rounding. Less of it is closed.
  static constexpr double kTolerance = 1e-9;

  double least = 0.0;         ///< m or rad, the smallest that it has been; 0 = closed
  std::uint32_t stalled = 0;  ///< steps since then

  bool is_open() const { return least > 0.0; }
  /// Joints whose gaps cannot close, as they contradict each other, may rest after so many steps.
  bool closes() const { return is_open() && stalled < 60; }
  void open(double size) {
    if (size > least) *this = {.least = size};
  }
  /// After a step. @param size  of what is left
  void settle(double size) {
    if (!is_open()) return;
    ++stalled;
    if (!(size > kTolerance)) *this = {};
    if (size < least) *this = {.least = size};
  }
};

}  // namespace tandem::pbd
