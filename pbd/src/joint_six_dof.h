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
/// Those of one joint.
void take_gradients(JointNode& node, JointRows& rows, const JointRecord& record,
                    const SolverBody& a, const SolverBody& b);
/// Inverse inertia times gradients, and the mobility of each row by itself.
void weigh(const JointPart& part);
/// Multipliers, or only those of brakes that were overcome, begin as the last substep left them;
/// slots have the moves that belong to them.
void warm_start(const JointPart& part, bool brakes_only);
/// Set the right-hand side.
/// @return whether other rows than before have a part in it
bool evaluate(const JointPart& part);
/// J, what motors and springs have done in this substep.
double supplied(const JointPart& part);
/// Set the matrix.
void assemble(const JointPart& part);
/// Multipliers grow by as much of the solution as their pieces allow, and bodies are to move by it.
/// A solution is the least of 1/2 |move|^2 in the metric of mass and what the rows store or take, a
/// convex function of the multipliers: the kinetic energy that joints add. So is what is taken of
/// it less than before, whatever the order of rows: all that pieces allow where that is, else as
/// far as the first corner.
/// @return whether that was all of it; else rows that have come to a corner are pinned
bool gather(const JointPart& part);
/// Leave out the rows that are pinned, and set the right-hand side to what the moves have left.
void pin(const JointPart& part);

}  // namespace tandem::pbd::joint_six_dof
