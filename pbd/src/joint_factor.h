// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

namespace tandem::pbd {

/// Block LDL^T of a part's matrix in place: the diagonal blocks end as inverses, the others as
/// blocks of L.
void factor(const JointPart& part);
/// Solve for the part's right-hand side, in place.
void solve(const JointPart& part);

}  // namespace tandem::pbd
