// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/pbd/constraint.h"

namespace tandem::pbd {

/// m/s^2: slow, light or shallow is measured by the world's gravity, but at least by this. With 0
/// no contact would count as solved, every overlap as deep and every approach as a bounce: in a row
/// of ten floating cubes squeezed by 10 N, 3528 rows were swept again in each step, the whole
/// budget, instead of none.
inline constexpr double kMinGravity = 1.0;

inline double gravity_of(const SubstepContext& ctx) {
  return std::max(ctx.gravity.norm(), kMinGravity);
}
/// m/s, velocity that gravity adds in a substep.
inline double fall_of(const SubstepContext& ctx) { return gravity_of(ctx) * ctx.h; }

}  // namespace tandem::pbd
