// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

/// Parts of the joint graph made of ball joints alone: the same rows as any joint's, in 3 x 3
/// blocks that always exist. A joint that breaks within a step keeps a block of its own. For the
/// functions see joint_six_dof.h.
namespace tandem::pbd::joint_points {

void begin(const JointPart& part);
void warm_start(const JointPart& part);
void weigh(const JointPart& part);
void take_gradients(const JointPart& part);
void evaluate(const JointPart& part);
void assemble(const JointPart& part);
void gather(const JointPart& part);

}  // namespace tandem::pbd::joint_points
