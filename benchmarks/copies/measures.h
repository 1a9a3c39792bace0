// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "copies/copy.h"

namespace tandem::peers_bench {

/// m, rms over bodies of the distance between two copies of each.
double apart(const Copy& a, const Copy& b);
/// m, deepest overlap of two boxes or of a box and a wall; 0 without overlap.
double deepest_overlap(const Copy& copy);
/// m, largest joint gap; 0 if there is none.
double widest_joint(const Copy& copy);

}  // namespace tandem::peers_bench
