// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "aabb_tree.h"
#include "collider.h"

namespace tandem::collision {

/// The colliders of a scene at their poses at one moment, with a search tree.
class QueryColliders {
 public:
  void update(const pbd::World& world, const CollisionScene& scene);

  std::uint32_t size() const { return static_cast<std::uint32_t>(entries_.size()); }
  /// Whether slot `index` holds a collider with a finite pose.
  bool present(std::uint32_t index) const { return entries_[index].present; }
  const Collider& collider(std::uint32_t index) const { return entries_[index].collider; }
  ColliderId id(std::uint32_t index) const { return {index, entries_[index].collider.generation}; }
  /// All colliders except half-spaces.
  const AabbTree& tree() const { return tree_; }
  /// Half-spaces, ascending.
  const std::vector<std::uint32_t>& half_spaces() const { return half_spaces_; }

 private:
  struct Entry {
    Collider collider;
    bool present = false;
    std::uint32_t leaf = AabbTree::kNone;
  };

  void renew(Entry& entry, const CollisionScene& scene, ColliderId id);
  void place(Entry& entry, std::uint32_t index, double margin);
  void drop(Entry& entry);

  std::vector<Entry> entries_;
  AabbTree tree_;
  std::vector<std::uint32_t> half_spaces_;
};

}  // namespace tandem::collision
