// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::nats {

/// A square of the x-y plane, for any z. Cells of level 0 are the smallest; 4 x 4 of one level make
/// one of the next.
struct TANDEM_API Cell {
  int level = 0;
  std::int32_t x = 0;  ///< of its minimal corner, in edges of its level
  std::int32_t y = 0;

  friend auto operator<=>(const Cell&, const Cell&) = default;
};

/// Division of space, and how far a user listens. The same for all members of a session but for
/// `max_near` and `min_near`.
struct TANDEM_API CellOptions {
  double edge = 8.0;  ///< m, of a cell of level 0, in [0.1, 1e5]
  int levels = 3;     ///< in [1, 6]; 1: no summaries of distant cells
  /// m: peers within this distance are connected, and receive all that concerns them; in [0, 16
  /// edges]
  double near = 8.0;
  double slack = 1.0;  ///< m: hysteresis before anything ends; in [0.01, near or 1 edge]
  /// Only this number of the nearest are connected; in [min_near, 256].
  std::size_t max_near = 16;
  std::size_t min_near = 2;  ///< kept if this peer is too slow for more; >= 1
  double presence_hz = 2.0;  ///< rate of announcing the position; in [0.2, 20]
  double summary_hz = 4.0;   ///< of cells of level 1, in [2, 5]; larger ones have 2 Hz

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// m: the edge of cells of a level.
TANDEM_API double cell_edge(const CellOptions& options, int level);
/// The cell of a level that contains a position (m, world). @pre finite; beyond 1e7 m it is the
/// last one
TANDEM_API Cell cell_at(const CellOptions& options, const pbd::Vec3& position, int level = 0);
/// The cell of the next level that contains this one.
TANDEM_API Cell parent_of(const Cell& cell);
/// m: distance of a position from a cell, the larger of x and y; 0 within it.
TANDEM_API double distance_to(const CellOptions& options, const Cell& cell,
                              const pbd::Vec3& position);

}  // namespace tandem::nats
