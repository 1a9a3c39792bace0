// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "contact_row.h"

namespace tandem::pbd {

/// Stop sliding and twisting as far as the load allows: the multipliers of the substep stay within
/// the ellipsoid (slide / limit)^2 + (twist / limit)^2 <= 1, about what a patch can do at once.
/// Returns the change of F_1, F_2 (N s) and T_n (N m s).
/// @param slip  V_1, V_2 (m/s) and W_n (rad/s) of the row
Vec3 rub(ContactRow& row, const Vec3& slip);

}  // namespace tandem::pbd
