// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/consensus/influence.h"
#include "tandem/pbd/portable.h"

namespace tandem::consensus {

/// Largest stable share of an extrapolated state that is `age` s old: 1 / (d + 2), d the age in
/// units of kShareInterval. Each of two peers takes the other's late correction for motion; at
/// shares near 1 / d these add up. Replayed means need no limit (docs/method.md Sec. 7).
inline double stable_share(double age) { return 1.0 / (std::max(age, 0.0) / kShareInterval + 2.0); }

/// The share of a leader's state whose news is `age` s old. A leader ignores others, so there is no
/// feedback: the gap decays with a time constant of 0.4 ages, at least of one interval. Faster
/// makes jumps (room at profile 5, p99: 4.4 mm, and 5.1 at half the time); slower lags (room at
/// profiles 1 and 3, p95: 1.5 and 3.2 mm, and 2.1 and 3.6 at a share of 0.5 for any age).
inline double following_share(double age) {
  constexpr double kPartOfAge = 0.4;
  return -pbd::portable::expm1(-kShareInterval / (kPartOfAge * std::max(age, kShareInterval)));
}

}  // namespace tandem::consensus
