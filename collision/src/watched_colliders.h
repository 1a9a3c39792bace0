// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collider.h"
#include "give_back.h"
#include "tandem/pbd/by_body.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// The colliders that a step looks at: those of bodies that may move, and of the others those that
/// have come, or whose body has changed, until they lie still.
class WatchedColliders {
 public:
  /// Ascending, between update() and the next add().
  std::span<const std::uint32_t> list() const { return list_; }
  void add(std::uint32_t collider);
  /// Bring the list up to date with the world.
  void update(const pbd::World& world, std::span<const Collider> colliders,
              const pbd::ByBody& by_body);
  /// Leave out what lies still.
  void leave_still(const pbd::World& world, std::span<const Collider> colliders);
  /// Give back memory that the list does not need.
  void trim() { give_back(list_); }
  /// The next update() looks at all colliders.
  void forget() { seen_ = {}; }

 private:
  std::vector<std::uint32_t> list_;
  std::vector<std::uint8_t> listed_;  ///< by collider
  bool in_order_ = true;
  pbd::BodyLog::Mark seen_;  ///< of the world
};

}  // namespace tandem::collision
