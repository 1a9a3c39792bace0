// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// How far springs are stretched between users' hands and what they hold, m: every spring of every
/// local peer at every step, at its own user's peer. A body counts as held by several where two or
/// more users of the whole session hold it at that time, at whichever peers they sit, and by one
/// otherwise; a user who holds it by more than one spring is one user. Of users in other processes
/// only those count whose springs have been announced.
struct Stretch {
  Distribution one_m, several_m;
};
Stretch stretch(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
