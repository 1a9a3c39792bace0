// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

/// Stability of joints beyond the resolution of the substep.
namespace tandem::pbd {

/// Adds geometric stiffness of joint forces to inertia.
void stiffen(const JointPart& part);
/// Resets bodies and multipliers to the start of the position iteration.
/// @param learn  use the multipliers so far as the load for stiffen()
void restart(const JointPart& part, bool learn);
/// Whether the corrections of this position iteration add energy.
bool adds_energy(const JointPart& part);
/// Whether limits and brakes, which may only take energy, have added some.
bool stops_add_energy(const JointPart& part);
/// J, work of joints in this position iteration.
double work_of(const JointPart& part);
/// Removes energy added so far by joints that do no work, before contacts pass it on.
void limit_turn(const JointPart& part);
/// Removes, or gives back, the work of joints that should do none.
void limit_energy_gain(const JointPart& part);

}  // namespace tandem::pbd
