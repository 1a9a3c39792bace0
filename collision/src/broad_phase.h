// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "aabb_tree.h"
#include "apart_bodies.h"
#include "collider.h"
#include "tandem/pbd/workers.h"

namespace tandem::collision {

/// Two colliders whose fat boxes overlap, by index, low < high.
struct ColliderPair {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t cache = 0;  ///< slot in the scene's caches; says nothing about order
  bool fresh = true;        ///< new in this step: the slot holds old data of another pair

  friend bool operator<(const ColliderPair& l, const ColliderPair& r) {
    return l.low != r.low ? l.low < r.low : l.high < r.high;
  }
};

/// Whether two colliders make contacts, by their bodies, kinds and filters. Pairs of bodies set
/// apart: see BroadPhase::meet().
bool may_touch(const Collider& a, const Collider& b);

/// m, largest distance that a collider may move before its fat box is rebuilt.
inline constexpr double kAabbMargin = 0.05;

/// Keeps the sorted list of pairs. Does no work for colliders that stay within their fat boxes.
class BroadPhase {
 public:
  void add(std::uint32_t index, const Collider& collider);
  void remove(std::uint32_t index, const Collider& collider);

  /// Whether two colliders make contacts in this step.
  bool meet(const Collider& a, const Collider& b) const {
    return may_touch(a, b) && !apart.contains(a.def.body.index, b.def.body.index);
  }
  /// Its changes take effect with ApartBodies::update(), for colliders passed to look_again().
  ApartBodies apart;

  /// Drops the collider's box and pairs, so that the next update() finds them again.
  void look_again(std::uint32_t index);

  /// Updates boxes and pairs from the colliders' `needed` boxes.
  /// @param watched  ascending; all except those at rest in their boxes
  void update(const std::vector<Collider>& colliders, std::span<const std::uint32_t> watched,
              double dt, pbd::Workers& workers);

  /// Frees memory that the last update() did not need.
  void trim();

  /// The pairs, without those of colliders that were removed since or passed to look_again().
  std::vector<ColliderPair>& pairs() {
    if (any_dropped_) drop_pairs([](const ColliderPair&) { return false; });
    return pairs_;
  }
  /// Calls visit(index) for each collider whose fat box overlaps `box`, and for each half-space.
  /// @param moving  false leaves out colliders of dynamic bodies
  void query(const Aabb& box, bool moving, std::vector<std::uint32_t>& stack, auto&& visit) const {
    fixed_tree_.query(box, stack, visit);
    if (moving) tree_.query(box, stack, visit);
    for (const std::uint32_t plane : half_spaces_) visit(plane);
  }
  /// Pairs that the last update() added; empty if it had nothing to do.
  const std::vector<ColliderPair>& found() const { return found_; }
  /// Lookups of a box in the last update().
  std::size_t searches() const { return moved_.size(); }
  /// Number of slots, used or free; a pair's `cache` is below it.
  std::uint32_t cache_slots() const { return cache_slots_; }
  /// For a half-space: the values that its range depended on in the last step.
  Aabb fat_box(std::uint32_t index) const;
  bool placed(std::uint32_t index) const { return leaves_[index] != AabbTree::kNone; }
  /// Whether the box was placed as that of an immovable collider.
  bool placed_fixed(std::uint32_t index) const {
    return placed(index) && (leaves_[index] & kFixed) != 0;
  }

  /// For load(): clear everything, then add boxes and pairs (ascending) one by one.
  void reset();
  void place(std::uint32_t index, const Aabb& fat, bool fixed);
  /// No effect unless it is a half-space.
  void remember_plane(std::uint32_t index, const Aabb& plane);
  ColliderPair& append_pair(std::uint32_t low, std::uint32_t high);
  /// Becomes a copy; scratch memory stays.
  void assign(const BroadPhase& source);

 private:
  /// Bit of a leaf's handle: it is in fixed_tree_.
  static constexpr std::uint32_t kFixed = 0x80000000u;

  const Aabb& fat(std::uint32_t index) const {
    const std::uint32_t leaf = leaves_[index] & ~kFixed;
    return placed_fixed(index) ? fixed_tree_.box(leaf) : tree_.box(leaf);
  }
  /// Removes the pairs of dropped colliders and those for which `parted` is true, in one pass.
  void drop_pairs(auto&& parted) {
    std::erase_if(pairs_, [&](const ColliderPair& pair) {
      const bool gone = dropped_[pair.low] != 0 || dropped_[pair.high] != 0 || parted(pair);
      if (gone) free_slots_.push_back(pair.cache);
      return gone;
    });
    if (any_dropped_) std::fill(dropped_.begin(), dropped_.end(), std::uint8_t{0});
    any_dropped_ = false;
  }
  void unlink(std::uint32_t index);
  bool still_close(const ColliderPair& pair, const std::vector<Collider>& colliders,
                   double dt) const;
  /// Whether update() can skip it: its box in the tree fits its place and motion.
  bool is_as_it_was(std::uint32_t index, const Collider& collider) const;
  void refit(std::uint32_t index, const Collider& collider);
  void index_pairs();
  bool known(std::uint32_t low, std::uint32_t high) const;
  void find(const std::vector<Collider>& colliders, double dt, pbd::Workers& workers);
  void merge_found();
  std::uint32_t take_slot();

  AabbTree tree_;                           ///< of dynamic bodies
  AabbTree fixed_tree_;                     ///< of all other bodies
  std::vector<std::uint32_t> leaves_;       ///< by collider
  std::vector<std::uint32_t> half_spaces_;  ///< ascending
  std::vector<Aabb> planes_;                ///< of half_spaces_: normal; offset, motion
  std::vector<ColliderPair> pairs_;
  std::vector<std::uint8_t> dropped_;  ///< by collider: its pairs must go
  bool any_dropped_ = false;
  std::vector<ColliderPair> found_;
  std::vector<std::uint32_t> moved_;
  std::vector<std::uint8_t> stays_;        ///< by watched collider, scratch of update()
  std::vector<std::uint32_t> unlinked_;    ///< leaves of fixed_tree_ that update() has prepared
  std::vector<std::uint8_t> has_moved_;    ///< by collider; 0 between two updates
  std::vector<std::uint32_t> flagged_;     ///< colliders set in has_moved_
  std::vector<std::uint32_t> first_pair_;  ///< by lower collider, into pairs_; see known()
  bool indexed_ = false;
  std::vector<std::uint32_t> free_slots_;
  /// Scratch of one worker.
  struct Search {
    std::vector<std::uint32_t> stack;
    std::vector<ColliderPair> found;
  };
  std::vector<Search> searches_;
  std::uint32_t cache_slots_ = 0;
};

}  // namespace tandem::collision
