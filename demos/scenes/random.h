// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/pbd/random.h"

namespace tandem::demos {

using Random = pbd::SplitMix64;

/// An independent seed for each use of one seed: `stream` distinguishes the uses.
inline std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t stream) {
  return Random(seed * 0x2545f4914f6cdd1dull + stream).next();
}

}  // namespace tandem::demos
