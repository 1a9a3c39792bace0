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

/// The colliders that a step looks at: those of bodies that may move, and others that were added or
/// whose body has changed, until they rest.
class WatchedColliders {
 public:
  /// Ascending, between update() and the next add().
  std::span<const std::uint32_t> list() const { return list_; }
  void add(std::uint32_t collider);
  /// Updates the list from the world.
  void update(const pbd::World& world, std::span<const Collider> colliders,
              const pbd::ByBody& by_body);
  /// Removes colliders at rest.
  void leave_still(const pbd::World& world, std::span<const Collider> colliders);
  /// Frees memory that the list does not need.
  void trim() { give_back(list_); }
  /// Makes the next update() look at all colliders.
  void forget() { seen_ = {}; }

 private:
  std::vector<std::uint32_t> list_;
  std::vector<std::uint8_t> listed_;  ///< by collider
  bool in_order_ = true;
  pbd::BodyLog::Mark seen_;  ///< of the world
};

}  // namespace tandem::collision
