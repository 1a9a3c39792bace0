// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "aabb_tree.h"

#include <algorithm>
#include <utility>

namespace tandem::collision {
namespace {

/// A leaf keeps its place while its parent grows by no more than this factor.
constexpr double kStays = 1.1;

/// So many leaves, and this share of all, are built into a subtree of their own.
constexpr std::size_t kMany = 256;
constexpr std::size_t kShare = 4;

}  // namespace

std::uint32_t AabbTree::take_node() {
  if (free_ == kNone) {
    nodes_.emplace_back();
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  const std::uint32_t index = free_;
  free_ = nodes_[index].parent;
  nodes_[index] = {};
  return index;
}

void AabbTree::free_node(std::uint32_t index) {
  nodes_[index] = {};
  nodes_[index].parent = free_;
  free_ = index;
}

std::uint32_t AabbTree::insert(const Aabb& box, std::uint32_t value) {
  const std::uint32_t leaf = prepare(box, value);
  link(leaf);
  return leaf;
}

std::uint32_t AabbTree::prepare(const Aabb& box, std::uint32_t value) {
  const std::uint32_t leaf = take_node();
  nodes_[leaf].box = box;
  nodes_[leaf].child[1] = value;
  return leaf;
}

void AabbTree::link_all(std::span<const std::uint32_t> leaves) {
  if (leaves.size() >= kMany && kShare * 2 * leaves.size() >= nodes_.size()) {
    nodes_.reserve(nodes_.size() + leaves.size());
    std::vector<Middle> middles;
    middles.reserve(leaves.size());
    for (const std::uint32_t leaf : leaves) {
      middles.push_back({nodes_[leaf].box.min + nodes_[leaf].box.max, leaf});
    }
    link(join(middles));
    return;
  }
  for (const std::uint32_t leaf : leaves) link(leaf);
}

/// Splits at the median of the longest axis of their centres.
std::uint32_t AabbTree::join(std::span<Middle> leaves) {
  if (leaves.size() == 1) return leaves[0].leaf;
  Aabb middles{leaves[0].at, leaves[0].at};
  for (const Middle& leaf : leaves) {
    middles = {middles.min.cwiseMin(leaf.at), middles.max.cwiseMax(leaf.at)};
  }
  int axis = 0;
  (middles.max - middles.min).maxCoeff(&axis);
  const std::size_t half = leaves.size() / 2;
  std::nth_element(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(half), leaves.end(),
                   [&](const Middle& l, const Middle& r) {
                     return std::pair(l.at[axis], l.leaf) < std::pair(r.at[axis], r.leaf);
                   });
  const std::uint32_t first = join(leaves.first(half));
  const std::uint32_t second = join(leaves.subspan(half));
  const std::uint32_t parent = take_node();
  nodes_[parent].box = nodes_[first].box.merged(nodes_[second].box);
  nodes_[parent].child[0] = first;
  nodes_[parent].child[1] = second;
  nodes_[first].parent = nodes_[second].parent = parent;
  return parent;
}

void AabbTree::remove(std::uint32_t leaf) {
  unlink(leaf);
  free_node(leaf);
}

void AabbTree::move(std::uint32_t leaf, const Aabb& box) {
  const std::uint32_t parent = nodes_[leaf].parent;
  if (parent != kNone) {
    const Node& above = nodes_[parent];
    const Aabb& sibling = nodes_[above.child[above.child[0] == leaf ? 1 : 0]].box;
    if (sibling.merged(box).half_area() <= kStays * above.box.half_area()) {
      nodes_[leaf].box = box;
      refit(parent, true);
      return;
    }
  }
  unlink(leaf);
  nodes_[leaf].box = box;
  link(leaf);
}

void AabbTree::clear() {
  nodes_.clear();
  root_ = kNone;
  free_ = kNone;
}

std::uint32_t AabbTree::best_sibling(const Aabb& box) const {
  // Greedy descent by surface area: descend while a child is cheaper than a new parent here.
  std::uint32_t index = root_;
  while (!nodes_[index].leaf()) {
    const double here = nodes_[index].box.half_area();
    const double together = nodes_[index].box.merged(box).half_area();
    const double inherited = together - here;
    double cost[2];
    for (int i = 0; i < 2; ++i) {
      const Node& child = nodes_[nodes_[index].child[i]];
      const double grown = child.box.merged(box).half_area();
      cost[i] = inherited + (child.leaf() ? grown : grown - child.box.half_area());
    }
    if (together < cost[0] && together < cost[1]) break;
    index = nodes_[index].child[cost[1] < cost[0] ? 1 : 0];
  }
  return index;
}

void AabbTree::link(std::uint32_t leaf) {
  nodes_[leaf].parent = kNone;
  if (root_ == kNone) {
    root_ = leaf;
    return;
  }
  const std::uint32_t sibling = best_sibling(nodes_[leaf].box);
  const std::uint32_t old_parent = nodes_[sibling].parent;
  const std::uint32_t parent = take_node();
  nodes_[parent].parent = old_parent;
  nodes_[parent].child[0] = sibling;
  nodes_[parent].child[1] = leaf;
  nodes_[sibling].parent = parent;
  nodes_[leaf].parent = parent;
  if (old_parent == kNone) {
    root_ = parent;
  } else {
    nodes_[old_parent].child[nodes_[old_parent].child[1] == sibling ? 1 : 0] = parent;
  }
  refit(parent, true);
}

void AabbTree::unlink(std::uint32_t leaf) {
  const std::uint32_t parent = nodes_[leaf].parent;
  if (parent == kNone) {
    root_ = kNone;
    return;
  }
  const std::uint32_t sibling = nodes_[parent].child[nodes_[parent].child[0] == leaf ? 1 : 0];
  const std::uint32_t above = nodes_[parent].parent;
  nodes_[sibling].parent = above;
  free_node(parent);
  if (above == kNone) {
    root_ = sibling;
    return;
  }
  nodes_[above].child[nodes_[above].child[1] == parent ? 1 : 0] = sibling;
  refit(above, false);
}

void AabbTree::refit(std::uint32_t index, bool improve) {
  for (; index != kNone; index = nodes_[index].parent) {
    Node& node = nodes_[index];
    const Aabb box = nodes_[node.child[0]].box.merged(nodes_[node.child[1]].box);
    // If the box is unchanged here, it is unchanged above.
    const bool same = box.min == node.box.min && box.max == node.box.max;
    node.box = box;
    if (improve) rotate(index);
    if (same) return;
  }
}

void AabbTree::rotate(std::uint32_t index) {
  // Swap a child with a grandchild of the other side if that shrinks the inner box most.
  int best_side = -1;
  int best_grandchild = 0;
  double best_gain = 0.0;
  for (int side = 0; side < 2; ++side) {
    const Node& inner = nodes_[nodes_[index].child[side]];
    if (inner.leaf()) continue;
    const Aabb& other = nodes_[nodes_[index].child[1 - side]].box;
    for (int g = 0; g < 2; ++g) {  // grandchild g and the other child swap
      const double area = nodes_[inner.child[1 - g]].box.merged(other).half_area();
      const double gain = inner.box.half_area() - area;
      if (gain > best_gain) {
        best_gain = gain;
        best_side = side;
        best_grandchild = g;
      }
    }
  }
  if (best_side < 0) return;
  const std::uint32_t inner = nodes_[index].child[best_side];
  const std::uint32_t other = nodes_[index].child[1 - best_side];
  const std::uint32_t grandchild = nodes_[inner].child[best_grandchild];
  nodes_[index].child[1 - best_side] = grandchild;
  nodes_[grandchild].parent = index;
  nodes_[inner].child[best_grandchild] = other;
  nodes_[other].parent = inner;
  nodes_[inner].box = nodes_[nodes_[inner].child[0]].box.merged(nodes_[nodes_[inner].child[1]].box);
}

}  // namespace tandem::collision
