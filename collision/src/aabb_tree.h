// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
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
  void remove(std::uint32_t leaf);
  /// The same handle with another box.
  void move(std::uint32_t leaf, const Aabb& box);
  void clear();

  const Aabb& box(std::uint32_t leaf) const { return nodes_[leaf].box; }

  /// Calls visit(value) for each leaf whose box meets `box`, in no particular order.
  template <class Visit>
  void query(const Aabb& box, std::vector<std::uint32_t>& stack, Visit&& visit) const {
    stack.clear();
    if (root_ != kNone) stack.push_back(root_);
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!node.box.overlaps(box)) continue;
      if (node.leaf()) {
        visit(node.value);
      } else {
        stack.push_back(node.child[0]);
        stack.push_back(node.child[1]);
      }
    }
  }

 private:
  struct Node {
    Aabb box;
    std::uint32_t parent = kNone;  ///< next free node while unused
    std::uint32_t child[2] = {kNone, kNone};
    std::uint32_t value = 0;
    bool leaf() const { return child[0] == kNone; }
  };

  std::uint32_t take_node();
  void free_node(std::uint32_t index);
  void link(std::uint32_t leaf);
  void unlink(std::uint32_t leaf);
  std::uint32_t best_sibling(const Aabb& box) const;
  void refit(std::uint32_t index, bool improve);
  void rotate(std::uint32_t index);

  std::vector<Node> nodes_;
  std::uint32_t root_ = kNone;
  std::uint32_t free_ = kNone;
};

}  // namespace tandem::collision
