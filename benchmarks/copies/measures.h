// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "copies/copy.h"

namespace tandem::peers_bench {

/// m, rms over bodies of the distance between two copies of each.
double apart(const Copy& a, const Copy& b);
/// m, of the boxes that are deepest in each other or in a wall; 0 where none are.
double deepest_overlap(const Copy& copy);
/// m, the widest open joint; 0 where there is none.
double widest_joint(const Copy& copy);

}  // namespace tandem::peers_bench
