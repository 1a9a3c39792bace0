// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

/// The rows of joints of any kind: from poses to a linear system, and from its solution to moves.
namespace tandem::pbd::joint_six_dof {

/// Take gradients and force laws from the poses as they are; multipliers start at 0.
void begin(const JointPart& part);
/// Take the gradients anew.
void take_gradients(const JointPart& part);
/// Inverse inertia times gradients, and the mobility of each row by itself.
void weigh(const JointPart& part);
/// Set the right-hand side.
/// @return whether other rows than before have a part in it
bool evaluate(const JointPart& part);
/// Set the matrix.
void assemble(const JointPart& part);
/// Multipliers grow by the solution, and bodies are to move by it.
void gather(const JointPart& part);

}  // namespace tandem::pbd::joint_six_dof
