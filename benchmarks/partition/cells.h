// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::partition_bench {

/// A box of space, along the axes of the world; open (infinite) where nothing lies beyond.
struct Cell {
  pbd::Vec3 min = pbd::Vec3::Constant(-std::numeric_limits<double>::infinity());  ///< m, world
  pbd::Vec3 max = pbd::Vec3::Constant(std::numeric_limits<double>::infinity());   ///< m, world
};

/// How far a point lies inside of a cell (m): to the nearest face; below 0, how far outside.
/// Of two cells that fill space together one's is minus the other's.
double depth_in(const Cell& cell, const pbd::Vec3& point);

/// Cut space into cells with about as many of the points in each: by a plane across one axis, then
/// each half across the next one that may be cut, and so on (k-d tree). Cells fill space without
/// overlap. The axes do not depend on the points: where these move, borders move and nothing else.
/// @param points  m, world; may be empty, then cuts are at the origin
/// @param count   cells, at least 1
/// @param axes    which axes may be cut; stacks stand better where only the level ones are
/// @throws std::invalid_argument where count is 0, a point is not finite, or no axis may be cut and
///   count is above 1
std::vector<Cell> split_cells(std::span<const pbd::Vec3> points, std::size_t count,
                              std::array<bool, 3> axes = {true, true, false});

}  // namespace tandem::partition_bench
