// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/types.h"

namespace tandem::scene_files {

/// A unit vector, up to round-off, that normalises to exactly the bits of `unit`. The receiver
/// normalises it again, which may change a unit vector. Searched among vectors that are longer by
/// parts of 1e-10; `unit` if none is found.
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
