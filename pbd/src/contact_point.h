// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "contact_row.h"

namespace tandem::pbd {

// Rows of one point. The general code gives the same bits: the point is the centre of pressure, so
// that s, r, the couple and the twist are 0, and what they are multiplied by is left out.

/// warm_start_row().
void warm_start_point(const ContactRow& row, SolverBody& a, SolverBody& b);

/// solve_row(); `turns`: how often normal and friction take turns.
double solve_point(ContactRow& row, ContactPass pass, int turns, SolverBody& a, SolverBody& b);

/// push_row(), of a row that is sunk or whose bodies were pushed.
bool push_point(const ContactRow& row, SolverBody& a, SolverBody& b);

}  // namespace tandem::pbd
