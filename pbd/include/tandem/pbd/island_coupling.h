// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// What one world knows of an island.
struct TANDEM_API IslandPart {
  bool awake = false;
  bool held = false;            ///< rests on or is joined to something that cannot move
  bool driven = false;          ///< by a motor or an anchor that moves
  bool sleepy = true;           ///< all of it may sleep and has been slow for long enough
  std::uint32_t level_sum = 0;  ///< of refinement, over its bodies
  std::uint32_t bodies = 0;     ///< those that are this world's own
  double wanted = 0.0;          ///< substeps that its rows ask for
};

/// Islands that go on in other worlds, each of which steps a part of them at the same time. Parts
/// of one island wake, sleep and are refined together. Entries of `islands` are indexed by the
/// lowest slot of a body of the island, as entries of `island_of` are; the others are unused.
/// @par Thread safety  Called by the thread that steps the world.
class TANDEM_API IslandCoupling {
 public:
  virtual ~IslandCoupling() = default;

  /// By slot: 1 where the body is a copy of another world's, which answers for it. Bodies that have
  /// no entry are this world's own.
  virtual std::span<const std::uint8_t> copies() const = 0;
  /// In each step, when it is known who touches whom: set `awake`, `level_sum` and `bodies` of
  /// islands that go on elsewhere to what holds for the whole island.
  virtual void agree_awake(std::span<const std::uint32_t> island_of,
                           std::span<IslandPart> islands) = 0;
  /// At the end of each step: the same for `held`, `driven`, `sleepy` and `wanted`.
  virtual void agree_rest(std::span<const std::uint32_t> island_of,
                          std::span<IslandPart> islands) = 0;
};

}  // namespace tandem::pbd
