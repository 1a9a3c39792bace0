// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/consensus/influence.h"
#include "tandem/pbd/portable.h"

namespace tandem::consensus {

/// The share given at most to a guess of where a body is now, made from a state that is `age` s
/// old: 1 / (d + 2), d the age in units of kShareInterval. Each of two peers takes the other's late
/// correction for motion; near 1 / d that adds up. Replayed means need no limit (docs/method.md
/// Sec. 7).
inline double stable_share(double age) { return 1.0 / (std::max(age, 0.0) / kShareInterval + 2.0); }

/// The share with which a leader is followed whose news are `age` s old. It listens to nobody, so
/// nothing comes back: what is missing decays with a time constant of 0.4 ages, of which none is
/// shorter than an interval. Sooner means jumps (room at profile 5, p99: 4.4 mm, and 5.1 with half
/// the time), later means way (room at profiles 1 and 3, p95: 1.5 and 3.2 mm, and 2.1 and 3.6 with
/// a share of 0.5 at any age).
inline double following_share(double age) {
  constexpr double kPartOfAge = 0.4;
  return -pbd::portable::expm1(-kShareInterval / (kPartOfAge * std::max(age, kShareInterval)));
}

}  // namespace tandem::consensus
