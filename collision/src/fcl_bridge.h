// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "convex_core.h"

namespace tandem::collision {

/// The collision library's answer for two convex shapes.
struct Direction {
  enum class Status : std::uint8_t {
    Apart,    ///< further apart than asked
    Found,    ///< `normal` is set
    Unknown,  ///< touching or overlapping, but the library has no (correct) direction
  };
  Status status = Status::Apart;
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b: the direction to push b out
};

/// Direction from a to b. The only code that knows the library's sign conventions.
/// @pre a.kind <= b.kind (the tests ask for every pair in both orders, one level up)
/// @param margin  m, >= 0: surfaces further apart than this count as apart
/// Allocates (the library does). Does not throw.
Direction query_direction(const ConvexCore& a, const ConvexCore& b, double margin) noexcept;

}  // namespace tandem::collision
