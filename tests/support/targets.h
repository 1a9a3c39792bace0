// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "support/bodies.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::testing {

/// Hands out what the test has put into `targets`, and counts the calls.
class FixedTargets final : public pbd::TargetSource {
 public:
  std::vector<pbd::PoseTarget> targets;
  int collected = 0;

  void collect(const pbd::World&, double, const pbd::SolverOptions&,
               std::vector<pbd::PoseTarget>& out) override {
    ++collected;
    out.insert(out.end(), targets.begin(), targets.end());
  }
};

/// The share of a remote weight against the local weight 1.
inline double share_of(double weight) { return weight / (1.0 + weight); }

}  // namespace tandem::testing
