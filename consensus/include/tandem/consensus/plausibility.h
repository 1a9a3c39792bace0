// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Limits on a body's motion between two states of a peer. They suit things that people handle, and
/// are generous: a peer within them may still lie.
struct TANDEM_API PlausibilityOptions {
  double max_speed = 200.0;  ///< m/s
  double jump = 0.25;        ///< m: how far agreement, or a hit, may move a body at once

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Whether a body can have moved from `last` to `next`, a later state of the same sender, given
/// nothing but their stamps: |next - last| <= jump + (2 v + v_agreed) dt + 1/2 a dt^2 with v the
/// larger of both speeds and a = 1000 m/s^2; orientations alike with 1 rad and 1000 rad/s^2; no hit
/// of more than 100 m/s, no spin above 1000 rad/s, and speeds within their limit. Agreement adds up
/// to `jump` in each 1/60 s. Cost O(1).
TANDEM_API bool plausible(const StateUpdate& last, const StateUpdate& next,
                          const PlausibilityOptions& limits);
/// The limits that apply to a single state.
TANDEM_API bool plausible(const StateUpdate& state, const PlausibilityOptions& limits);

}  // namespace tandem::consensus
