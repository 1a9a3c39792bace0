// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <span>

#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Several peers' states of one body at one time combined into one state, whose weight is the sum
/// of theirs:
///   x = sum w_i x_i / W,  influence = W / (1 + W),  W = sum w_i,  w_i = s_i / (1 - s_i),
/// positions, twists and orientations as in fuse() of aggregate.h. A receiver of the combined state
/// gets the same target ([friston] Eqs. 1 and 2 are sums over peers), and cannot tell it from one
/// peer with that weight. Receivers accept a share of at most 0.5, a weight of 1, for a state that
/// neither leads nor owns.
///
/// If a peer leads the body, only leaders' states count, as at a receiver. The result rests if all
/// states rest, is oriented if all are, and touches, is held or has jumped if any state says so.
/// @pre numbers as check() requires  @return none if there is no state, if ids or stamps differ, or
/// if no state has a weight
TANDEM_API std::optional<StateUpdate> fuse(std::span<const StateUpdate> states);

}  // namespace tandem::consensus
