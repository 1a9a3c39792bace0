// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/pbd/constraint.h"

namespace tandem::pbd {

/// m/s^2: what is slow, light or shallow between bodies is measured by the gravity of the world,
/// and by this one at least. By none, what touches is never solved, whatever is deep is pushed and
/// whatever meets bounces: of a row of ten cubes that floats and is squeezed by 10 N, 3528 rows
/// were swept again in each step, all that the budget has, in place of none.
inline constexpr double kMinGravity = 1.0;

inline double gravity_of(const SubstepContext& ctx) {
  return std::max(ctx.gravity.norm(), kMinGravity);
}
/// m/s, what it adds in a substep.
inline double fall_of(const SubstepContext& ctx) { return gravity_of(ctx) * ctx.h; }

}  // namespace tandem::pbd
