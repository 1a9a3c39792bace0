// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

/// What keeps joints stable where the substep does not resolve them.
namespace tandem::pbd {

/// Add to inertia what the forces of joints make stiff.
void stiffen(const JointPart& part);
/// Put bodies and multipliers back to where the position iteration began.
/// @param learn  whether the multipliers so far are the load that bodies are stiffened by
void restart(const JointPart& part, bool learn);
/// Whether the corrections of this position iteration add energy.
bool adds_energy(const JointPart& part);
/// Whether limits and brakes, which take energy only, have added some.
bool stops_add_energy(const JointPart& part);
/// J, of joints in this position iteration.
double work_of(const JointPart& part);
/// Take back what joints that do no work have added so far, before contacts pass it on.
void limit_turn(const JointPart& part);
/// Take back, or give back, what joints that do no work did.
void limit_energy_gain(const JointPart& part);

}  // namespace tandem::pbd
