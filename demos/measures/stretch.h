// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// Stretch of springs between users' hands and held bodies, m: every spring of every local peer at
/// every step, at its own user's peer. several_m: bodies held by two or more users of the session
/// at that time, at any peers; one_m: all others. Several springs of one user count as one holder.
/// Users in other processes count once their springs were announced.
struct Stretch {
  Distribution one_m, several_m;
};
Stretch stretch(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
