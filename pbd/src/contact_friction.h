// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "contact_row.h"

namespace tandem::pbd {

/// Stop sliding and twisting as far as the load allows: the multipliers of the substep stay within
/// the ellipsoid (slide / limit)^2 + (twist / limit)^2 <= 1, about what a patch can do at once.
/// @param slip    V_1, V_2 (m/s) and W_n (rad/s) of the row
/// @param wrench  gets the change of friction's components
void rub(ContactRow& row, const Vec3& slip, ContactWrench& wrench);

}  // namespace tandem::pbd
