// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Sets of movable bodies that rows join, directly or through each other. Immovable bodies separate
/// islands.
class Islands {
 public:
  /// @param movers  all bodies that may be movable, ascending
  void build(std::span<const ConstraintEdge> edges, std::span<const std::uint32_t> movers,
             std::span<const SolverBody> bodies);

  /// By mover: the lowest index of a body in its island; its own index if nothing joins it.
  std::span<const std::uint32_t> of() const { return island_of_; }

 private:
  std::uint32_t root_of(std::uint32_t body);

  detail::SparseArray<std::uint32_t> island_of_;
};

}  // namespace tandem::pbd
