// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// One world's knowledge of an island.
struct TANDEM_API IslandPart {
  bool awake = false;
  bool held = false;            ///< rests on or is joined to something immovable
  bool driven = false;          ///< by a motor or a moving anchor
  bool sleepy = true;           ///< all its bodies may sleep and have been slow for long enough
  std::uint32_t level_sum = 0;  ///< sum of refinement levels over its bodies
  std::uint32_t bodies = 0;     ///< bodies that belong to this world
  double wanted = 0.0;          ///< substeps that its rows want
};

/// Islands that extend over several worlds, each of which steps a part of them at the same time.
/// Parts of one island wake, sleep and are refined together. Entries of `islands` are indexed by
/// the lowest slot of the island's bodies, the value that `island_of` holds; other entries are
/// unused.
/// @par Thread safety  Called by the thread that steps the world.
class TANDEM_API IslandCoupling {
 public:
  virtual ~IslandCoupling() = default;

  /// By slot: 1 for a copy of a body of another world. Bodies without an entry belong to this
  /// world.
  virtual std::span<const std::uint8_t> copies() const = 0;
  /// In each step, once islands are known: set `awake`, `level_sum` and `bodies` of islands that
  /// extend to other worlds to the values of the whole island.
  virtual void agree_awake(std::span<const std::uint32_t> island_of,
                           std::span<IslandPart> islands) = 0;
  /// At the end of each step: set `held`, `driven`, `sleepy` and `wanted` likewise.
  virtual void agree_rest(std::span<const std::uint32_t> island_of,
                          std::span<IslandPart> islands) = 0;
};

}  // namespace tandem::pbd
