// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem::scene_files {

struct JointStart {
  double at = 0.0;     ///< m or rad
  double moved = 0.0;  ///< m or rad, distance from the wanted one; 0 if that is allowed
};

/// The coordinate within limits that is nearest to `wanted`.
/// @param turns  whether another full turn is the same pose
inline JointStart start_in_range(double wanted, double lower, double upper, bool turns) {
  JointStart best{std::clamp(wanted, lower, upper), HUGE_VAL};
  const auto look = [&](double same) {
    const double at = std::clamp(same, lower, upper);
    // Of two equally near ones the first counts, whatever rounding does.
    if (std::abs(at - same) < best.moved - 1e-12) best = {at, std::abs(at - same)};
  };
  look(wanted);
  if (turns) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    for (const double limit : {lower, upper}) {
      const double count = std::floor((limit - wanted) / kTurn);
      if (!std::isfinite(count)) continue;
      look(wanted + count * kTurn);
      look(wanted + (count + 1.0) * kTurn);
    }
  }
  // Limits in files are rounded.
  if (best.moved < 1e-9) best.moved = 0.0;
  return best;
}

}  // namespace tandem::scene_files
