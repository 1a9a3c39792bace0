// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"

namespace tandem::collision {

/// Binary tree of boxes that changes leaf by leaf. Its shape depends on the order of changes; what
/// a query finds does not, and callers sort it.
class AabbTree {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// @return the leaf's handle
  std::uint32_t insert(const Aabb& box, std::uint32_t value);
  /// A leaf that is in the tree once link_all() was called: of many at once it makes a better tree,
  /// in less time.
  std::uint32_t prepare(const Aabb& box, std::uint32_t value);
  /// @param leaves  handles of prepare()
  void link_all(std::span<const std::uint32_t> leaves);
  void remove(std::uint32_t leaf);
  /// The same handle with another box.
  void move(std::uint32_t leaf, const Aabb& box);
  void clear();

  const Aabb& box(std::uint32_t leaf) const { return nodes_[leaf].box; }

  /// Calls visit(value) for each leaf whose box meets `box`, in no particular order.
  void query(const Aabb& box, std::vector<std::uint32_t>& stack, auto&& visit) const {
    stack.clear();
    const auto meets = [&](std::uint32_t index) { return nodes_[index].box.overlaps(box); };
    if (root_ == kNone || !meets(root_)) return;
    for (std::uint32_t at = root_;;) {
      const Node& node = nodes_[at];
      if (node.leaf()) {
        visit(node.value());
      } else {
        // Only what has to wait goes on the stack.
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

  /// Calls visit(value) for each leaf that is reached through boxes which enter(box) accepts, in
  /// the order that second_first(first child's box, second child's box) tells. That one must not
  /// change on the way; enter() may. Allocates nothing.
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
      // Up, to the first ancestor whose later child has not been seen. The parents are the stack:
      // nothing bounds the depth of this tree.
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
  /// One line of the nearest memory.
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
  /// A leaf and the middle of its box, twice.
  struct Middle {
    pbd::Vec3 at;
    std::uint32_t leaf;
  };
  /// @return the root of a tree of its own
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
