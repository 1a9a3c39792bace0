// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/consensus/influence.h"

namespace tandem::consensus {

/// The share given at most to a guess of where a body is now, made from a state that is `age` s
/// old: 1 / (d + 2), d the age in units of kShareInterval. Each of two peers takes the other's late
/// correction for motion; near 1 / d that adds up. Replayed means need no limit (docs/method.md
/// Sec. 7).
inline double stable_share(double age) { return 1.0 / (std::max(age, 0.0) / kShareInterval + 2.0); }

}  // namespace tandem::consensus
