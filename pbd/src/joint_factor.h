// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_part.h"

namespace tandem::pbd {

/// Block LDL^T of a part's matrix in place: diagonal blocks become inverses, the others blocks of
/// L.
void factor(const JointPart& part);
/// Solves for the part's right-hand side, in place.
void solve(const JointPart& part);

}  // namespace tandem::pbd
