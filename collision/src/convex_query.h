// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "pair_query.h"

namespace tandem::collision {

/// Contact of two convex colliders, or of a convex one with a half-space b, as it will be when they
/// meet; positions relative to a, at the current poses.
/// @return number of narrow-phase queries
std::size_t query_convex(const QueryPair& pair, const Reach& reach, PairCache& cache,
                         RawManifold& out);

}  // namespace tandem::collision
