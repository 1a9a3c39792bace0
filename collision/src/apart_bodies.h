// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Pairs of bodies whose colliders make no contacts with each other: named by the application, or
/// kept apart by joints in this step.
class ApartBodies {
 public:
  /// Whether the pair is kept apart.
  bool contains(std::uint32_t a, std::uint32_t b) const {
    return !all_.empty() && find(pbd::BodyPair::of(a, b));
  }
  bool named(std::uint32_t a, std::uint32_t b) const;
  /// Pairs that the application named, by slot, ascending.
  std::span<const pbd::BodyPair> named() const { return named_; }
  /// @return whether this changed anything
  bool name(pbd::BodyPair pair, bool apart);
  void remove_body(std::uint32_t body);
  /// Updates the pairs from the world's joints; calls visit(body) for the bodies of each pair that
  /// was added or removed since the last call.
  void update(const pbd::World& world, auto&& visit) {
    if (!renew(world)) return;
    for (const pbd::BodyPair& pair : changed_) {
      visit(pair.low);
      visit(pair.high);
    }
  }

  void save(pbd::ByteWriter& out) const;
  /// @return false if the input has no valid pairs of bodies
  bool load(pbd::ByteReader& in);

 private:
  bool find(pbd::BodyPair pair) const;
  /// @return whether anything has changed
  bool renew(const pbd::World& world);

  std::vector<pbd::BodyPair> named_;           ///< ascending
  std::vector<pbd::BodyPair> all_;             ///< ascending, as of the last update()
  std::vector<pbd::BodyPair> next_, changed_;  ///< scratch
};

}  // namespace tandem::collision
