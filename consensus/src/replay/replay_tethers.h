// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "input/springs.h"

namespace tandem::consensus {

/// Users' springs in the scratch world of a replay, as they pulled in each of its steps.
class ReplayTethers {
 public:
  ReplayTethers(const WorldHistory& history, const Springs& springs, ReplayInputs inputs)
      : history_(history), springs_(springs), inputs_(inputs) {}

  /// `scratch` is a copy of `world`, with these rows of the springs' block.
  /// @param known_until  ns, end of the local inputs used with ReplayInputs::Common
  void begin(const pbd::World& world, pbd::World& scratch, std::span<const pbd::ConstraintId> rows,
             SessionTime known_until);
  /// Set them for the step of `dt` s from that time on.
  void apply(pbd::World& scratch, SessionTime time, double dt);

 private:
  const WorldHistory& history_;
  const Springs& springs_;
  ReplayInputs inputs_;
  SessionTime known_until_ = 0;      ///< ns
  pbd::Tethers* tethers_ = nullptr;  ///< of the scratch world
  std::vector<pbd::ConstraintId> rows_;
  std::vector<pbd::Tether::Def> pulls_;
};

}  // namespace tandem::consensus
