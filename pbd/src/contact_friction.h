// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "contact_row.h"

namespace tandem::pbd {

/// Where friction acts in this step and how easily the bodies slide and twist there. The centre of
/// pressure comes from the carried forces; points near each other's surface serve where none is.
void prepare_friction(const Contact& contact, const ContactArms& arms, const SolverBody& a,
                      const SolverBody& b, ContactRow& row);

/// Stop sliding and twisting as far as the load allows: the multipliers of the substep stay within
/// the ellipsoid (slide / limit)^2 + (twist / limit)^2 <= 1, about what a patch can do at once.
void rub(ContactRow& row, SolverBody& a, SolverBody& b);

/// Change v and w as friction impulses do: `slide` (N s) along the tangents, `twist` (N m s) about
/// the normal.
void apply_friction(const ContactRow& row, const std::array<double, 2>& slide, double twist,
                    SolverBody& a, SolverBody& b);

}  // namespace tandem::pbd
