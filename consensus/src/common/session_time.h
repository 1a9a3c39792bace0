// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/consensus/transport.h"

namespace tandem::consensus {

/// s per ns.
inline constexpr double kNs = 1e-9;

inline double seconds(SessionTime ns) { return kNs * static_cast<double>(ns); }

/// Rounds to the nearest nanosecond.
inline SessionTime to_ns(double seconds) {
  return static_cast<SessionTime>(std::floor(seconds * 1e9 + 0.5));
}

}  // namespace tandem::consensus
