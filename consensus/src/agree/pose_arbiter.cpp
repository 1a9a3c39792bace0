// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/pose_arbiter.h"

#include <algorithm>

namespace tandem::consensus {

double PoseArbiter::weight(double weight, double angle, bool follows) {
  const double doubt = std::clamp((angle - kFromAngle) / (kToAngle - kFromAngle), 0.0, 1.0);
  const double left = 1.0 - doubt;
  return follows ? weight / left : weight * left;
}

}  // namespace tandem::consensus
