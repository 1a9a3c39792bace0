// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <span>

#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Several peers' states of one body at one time as one state, whose weight is the sum of theirs:
///   x = sum w_i x_i / W,  influence = W / (1 + W),  W = sum w_i,  w_i = s_i / (1 - s_i),
/// positions, twists and orientations as fuse() of aggregate.h has them. Who hears it in their
/// place comes to the same target ([friston] Eqs. 1 and 2 are sums over peers), and cannot tell it
/// from a peer with that weight. Receivers give a state that does not lead or own a share of 0.5 at
/// most, a weight of 1.
///
/// Where somebody leads the body the leaders' states count alone, as they do at a receiver. It
/// rests where all say so, it is oriented where all are, and it touches, is held or has jumped
/// where anybody says so.
/// @pre numbers as check() wants them  @return none where there is no state, where ids or stamps
///   differ, or where no state has a weight
TANDEM_API std::optional<StateUpdate> fuse(std::span<const StateUpdate> states);

}  // namespace tandem::consensus
