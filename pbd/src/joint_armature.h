// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

namespace tandem::pbd {

/// Adds inertia of coordinates to the laws of a joint. Without force they go on at the rate of the
/// last substep, which is that between its poses: by gradients of this one it would be off by half
/// of what the joint's turning changes in them, at any length of substep.
/// @param h  s, of the substep; bodies are at its start
void add_armature(const JointRecord& record, JointRows& rows, const SolverBody& a,
                  const SolverBody& b, double h);

}  // namespace tandem::pbd
