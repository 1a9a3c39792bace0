// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// How a body may move from one state of a peer to a later one. The limits are of things that
/// people handle, and generous; a peer within all of them may still lie.
struct TANDEM_API PlausibilityOptions {
  double max_speed = 200.0;  ///< m/s
  double max_spin = 1000.0;  ///< rad/s
  /// m and rad: what agreement, or something hit, may do at once.
  double jump = 0.25;
  double turn = 1.0;
  double max_acceleration = 1000.0;       ///< m/s^2, of what happens between two states
  double max_spin_acceleration = 1000.0;  ///< rad/s^2
  double max_hit = 100.0;                 ///< m/s, change of velocity at once
  /// s: jumps that the sender tells of (UpdateFlags::teleported) are believed no more often. A
  /// state after a silence as long as InboxOptions::max_age is not judged by what was before.
  double teleport_interval = 0.2;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Whether a body can have come from `last` to `next`, a later state by the same sender, given
/// nothing but their stamps: |next - last| <= jump + (2 v + v_agreed) dt + 1/2 a dt^2 with v the
/// larger of both speeds, orientations likewise, and speeds within their limits. Agreement adds up
/// to `jump` and `turn` in each 1/60 s. Cost O(1).
TANDEM_API bool plausible(const StateUpdate& last, const StateUpdate& next,
                          const PlausibilityOptions& limits);
/// What can be said of a state alone.
TANDEM_API bool plausible(const StateUpdate& state, const PlausibilityOptions& limits);

}  // namespace tandem::consensus
