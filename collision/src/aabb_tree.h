// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"

namespace tandem::collision {

/// Dynamic binary tree of boxes. Its shape depends on the order of changes; the set of query
/// results does not, and callers sort them.
class AabbTree {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// @return the leaf's handle
  std::uint32_t insert(const Aabb& box, std::uint32_t value);
  /// Makes a leaf that link_all() adds to the tree: for many at once this gives a better tree,
  /// faster.
  std::uint32_t prepare(const Aabb& box, std::uint32_t value);
  /// @param leaves  handles of prepare()
  void link_all(std::span<const std::uint32_t> leaves);
  void remove(std::uint32_t leaf);
  /// Moves the leaf to another box; the handle stays.
  void move(std::uint32_t leaf, const Aabb& box);
  void clear();

  const Aabb& box(std::uint32_t leaf) const { return nodes_[leaf].box; }

  /// Calls visit(value) for each leaf whose box overlaps `box`, in unspecified order.
  void query(const Aabb& box, std::vector<std::uint32_t>& stack, auto&& visit) const {
    stack.clear();
    const auto meets = [&](std::uint32_t index) { return nodes_[index].box.overlaps(box); };
    if (root_ == kNone || !meets(root_)) return;
    for (std::uint32_t at = root_;;) {
      const Node& node = nodes_[at];
      if (node.leaf()) {
        visit(node.value());
      } else {
        // Only one child goes on the stack, if both meet.
        const bool first = meets(node.child[0]);
        const bool second = meets(node.child[1]);
        if (first && second) stack.push_back(node.child[0]);
        at = second ? node.child[1] : node.child[0];
        if (first || second) continue;
      }
      if (stack.empty()) return;
      at = stack.back();
      stack.pop_back();
    }
  }

  /// Calls visit(value) for each leaf that is reached through boxes accepted by enter(box).
  /// second_first(first child's box, second child's box) selects the order; it must not change
  /// during the walk, enter() may. Allocates nothing.
  template <class SecondFirst, class Enter, class Visit>
  void walk(SecondFirst&& second_first, Enter&& enter, Visit&& visit) const {
    const auto first_of = [&](const Node& node) {
      return second_first(nodes_[node.child[0]].box, nodes_[node.child[1]].box) ? 1 : 0;
    };
    std::uint32_t index = root_;
    while (index != kNone) {
      const Node& node = nodes_[index];
      if (enter(node.box)) {
        if (!node.leaf()) {
          index = node.child[first_of(node)];
          continue;
        }
        visit(node.value());
      }
      // Up to the first ancestor whose later child is unseen. Parent links replace a stack, since
      // the depth of this tree is unbounded.
      for (;;) {
        const std::uint32_t parent = nodes_[index].parent;
        if (parent == kNone) return;
        const int first = first_of(nodes_[parent]);
        const bool later = nodes_[parent].child[first] == index;
        index = later ? nodes_[parent].child[1 - first] : parent;
        if (later) break;
      }
    }
  }

 private:
  /// One cache line.
  struct alignas(64) Node {
    Aabb box;
    std::uint32_t parent = kNone;             ///< next free node while unused
    std::uint32_t child[2] = {kNone, kNone};  ///< of a leaf: none, and its value
    bool leaf() const { return child[0] == kNone; }
    std::uint32_t value() const { return child[1]; }
  };

  std::uint32_t take_node();
  void free_node(std::uint32_t index);
  void link(std::uint32_t leaf);
  /// A leaf and twice the centre of its box.
  struct Middle {
    pbd::Vec3 at;
    std::uint32_t leaf;
  };
  /// @return the root of the new subtree
  std::uint32_t join(std::span<Middle> leaves);
  void unlink(std::uint32_t leaf);
  std::uint32_t best_sibling(const Aabb& box) const;
  void refit(std::uint32_t index, bool improve);
  void rotate(std::uint32_t index);

  std::vector<Node> nodes_;
  std::uint32_t root_ = kNone;
  std::uint32_t free_ = kNone;
};

}  // namespace tandem::collision
