// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/types.h"

namespace tandem::scene_files {

/// A vector of unit length by round-off that normalises to the very bits of `unit`: those who are
/// given it normalise it once more, which need not leave a unit vector as it is. Looked for among
/// vectors that are longer by parts of 1e-10; `unit` where none is found.
template <class Vector>
Vector before_normalized(const Vector& unit) {
  constexpr int kTries = 4096;
  for (int i = 0; i < kTries; ++i) {
    const Vector tried = unit * (1.0 + i * 0x1p-46);
    if (tried.normalized() == unit) return tried;
  }
  return unit;
}

}  // namespace tandem::scene_files
