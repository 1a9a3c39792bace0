// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

/// The rows of joints of any kind: from poses to a linear system, and from its solution to moves.
namespace tandem::pbd::joint_six_dof {

/// Takes gradients and force laws from the current poses; multipliers start at 0.
void begin(const JointPart& part);
/// Updates the gradients.
void take_gradients(const JointPart& part);
/// Updates the gradients of one joint.
void take_gradients(JointNode& node, JointRows& rows, const JointRecord& record,
                    const SolverBody& a, const SolverBody& b);
/// Computes inverse inertia times gradients, and the mobility of each row alone.
void weigh(const JointPart& part);
/// Starts from the multipliers of the last substep, or from those of overcome brakes only; sets the
/// moves of slots accordingly.
void warm_start(const JointPart& part, bool brakes_only);
/// Sets the right-hand side.
/// @return whether the set of rows has changed
bool evaluate(const JointPart& part);
/// J, work of motors and springs in this substep.
double supplied(const JointPart& part);
/// Sets the matrix.
void assemble(const JointPart& part);
/// Adds as much of the solution to the multipliers as their pieces allow, and gathers
/// the moves of bodies. A solution minimises 1/2 |move|^2 in the metric of mass plus the energy
/// that rows store or take, a convex function of the multipliers: the kinetic energy that joints
/// add. A partial step lowers it too, whatever the order of rows: all that pieces allow if that
/// lowers it, else up to the first corner.
/// @return whether all of it was used; otherwise rows at a corner are pinned
bool gather(const JointPart& part);
/// Removes pinned rows, and sets the right-hand side to the remaining residuals.
void pin(const JointPart& part);

}  // namespace tandem::pbd::joint_six_dof
