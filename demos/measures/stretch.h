// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// Stretch of springs between users' hands and held bodies, m: every spring of every local peer at
/// every step. several_m: bodies held by two or more users of the session at that time; one_m: all
/// others. Users in other processes count once their springs were announced.
struct Stretch {
  Distribution one_m, several_m;
};
Stretch stretch(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
