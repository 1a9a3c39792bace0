// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

namespace tandem::pbd {

/// One Newton iteration of a part: rows from poses, poses from multipliers.
/// @return estimate of the remaining error of bodies, m
double newton_iteration(const JointPart& part);

}  // namespace tandem::pbd
