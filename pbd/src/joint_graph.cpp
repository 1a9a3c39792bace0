// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_graph.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "joint_elimination.h"

namespace tandem::pbd {
namespace {

constexpr int kHubRows = 6;
/// Limit of block operations for fill-in per node: a lattice of 30 x 30 bodies takes 300. Cut
/// loops open by a centimetre and lose energy, so only cases that would take seconds are cut.
constexpr std::size_t kUpdatesPerNode = 500;

class Sets {
 public:
  explicit Sets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }
  /// @return whether the two sets were separate
  bool join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    parents_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace

void JointGraph::build(std::span<const Edge> edges) {
  nodes_.clear();
  later_.clear();
  updates_.clear();
  links_.clear();
  bodies_.clear();
  hubs_.clear();
  parts_.clear();
  value_count_ = 0;
  right_count_ = 0;
  std::uint32_t body_count = 0;
  for (const Edge& edge : edges) {
    for (const std::uint32_t body : {edge.a, edge.b}) {
      if (body != kNone) body_count = std::max(body_count, body + 1);
    }
  }
  Sets islands(body_count);
  for (const Edge& edge : edges) {
    if (edge.a != kNone && edge.b != kNone) islands.join(edge.a, edge.b);
  }
  // Joints by island, in the order of each island's lowest joint.
  std::vector<std::vector<Edge>> groups;
  std::vector<std::uint32_t> group_of(body_count, kNone);
  for (const Edge& edge : edges) {
    const std::uint32_t body = edge.b != kNone ? edge.b : edge.a;
    if (body == kNone) continue;  // both ends are immovable
    std::uint32_t& group = group_of[islands.root(body)];
    if (group == kNone) {
      group = static_cast<std::uint32_t>(groups.size());
      groups.emplace_back();
    }
    groups[group].push_back(edge);
  }
  for (const std::vector<Edge>& group : groups) {
    if (add_part(group, true)) continue;
    // Too many loops: a spanning tree as one part, the joints that close loops one by one.
    Sets trees(body_count);
    std::vector<Edge> tree;
    std::vector<Edge> closing;
    for (const Edge& edge : group) {
      const bool loop = edge.a != kNone && edge.b != kNone && !trees.join(edge.a, edge.b);
      (loop ? closing : tree).push_back(edge);
    }
    add_part(tree, false);
    for (const Edge& edge : closing) add_part({&edge, 1}, false);
  }
}

bool JointGraph::add_part(std::span<const Edge> edges, bool may_refuse) {
  JointElimination plan(edges);
  const std::size_t most =
      may_refuse ? kUpdatesPerNode * plan.node_count() : std::numeric_limits<std::size_t>::max();
  if (!plan.run(most)) return false;
  const std::vector<std::uint32_t>& bodies = plan.bodies();
  Part part{};
  part.node = static_cast<std::uint32_t>(nodes_.size());
  part.node_count = plan.node_count();
  part.body = static_cast<std::uint32_t>(bodies_.size());
  part.body_count = static_cast<std::uint32_t>(bodies.size());
  part.link = static_cast<std::uint32_t>(links_.size());
  part.value = value_count_;
  const bool hangs = std::any_of(edges.begin(), edges.end(),
                                 [](const Edge& e) { return e.a == kNone || e.b == kNone; });
  part.regular = edges.size() + (hangs ? 0 : 1) == bodies.size();
  part.points = part.node_count == edges.size() &&
                std::all_of(edges.begin(), edges.end(), [](const Edge& e) { return e.point; });
  bodies_.insert(bodies_.end(), bodies.begin(), bodies.end());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    hubs_.push_back(plan.hub_of(body) != kNone ? 1 : 0);
  }
  place_nodes(edges, plan, part);
  place_blocks(plan, part);
  place_updates(part);
  place_links(plan, part);
  part.link_count = static_cast<std::uint32_t>(links_.size()) - part.link;
  part.value_count = value_count_ - part.value;
  parts_.push_back(part);
  return true;
}

void JointGraph::place_nodes(std::span<const Edge> edges, const JointElimination& plan,
                             const Part& part) {
  for (const std::uint32_t i : plan.order()) {
    Node node;
    if (i < edges.size()) {
      node.joint = edges[i].joint;
      node.rows = edges[i].rows;
      node.point = edges[i].point;
      if (edges[i].a != kNone) node.slot_a = part.body + plan.local(edges[i].a);
      if (edges[i].b != kNone) node.slot_b = part.body + plan.local(edges[i].b);
    } else {
      node.rows = kHubRows;
      node.slot_b = part.body + plan.body_of_hub(i);
    }
    node.diagonal = value_count_;
    value_count_ += static_cast<std::uint32_t>(node.rows * node.rows);
    node.right = right_count_;
    right_count_ += static_cast<std::uint32_t>(node.rows);
    nodes_.push_back(node);
  }
}

void JointGraph::place_blocks(const JointElimination& plan, const Part& part) {
  for (std::uint32_t k = 0; k < part.node_count; ++k) {
    Node& node = nodes_[part.node + k];
    node.later = static_cast<std::uint32_t>(later_.size());
    for (const std::uint32_t place : plan.later_places(k)) {
      const Node& other = nodes_[part.node + place];
      later_.push_back({part.node + place, value_count_, other.right});
      value_count_ += static_cast<std::uint32_t>(node.rows * other.rows);
    }
    node.later_count = static_cast<std::uint32_t>(later_.size()) - node.later;
  }
}

std::uint32_t JointGraph::block_between(std::uint32_t earlier, std::uint32_t later_node) const {
  const Node& node = nodes_[earlier];
  for (std::uint32_t l = node.later; l < node.later + node.later_count; ++l) {
    if (later_[l].node == later_node) return later_[l].block;
  }
  return kNone;
}

void JointGraph::place_updates(const Part& part) {
  for (std::uint32_t k = 0; k < part.node_count; ++k) {
    Node& node = nodes_[part.node + k];
    node.update = static_cast<std::uint32_t>(updates_.size());
    updates_.resize(updates_.size() + (node.later_count + 1) * node.later_count / 2);
    // Row i ends with the diagonal. Later neighbours of a node are neighbours of each other.
    for (std::uint32_t j = 0; j < node.later_count; ++j) {
      const Node& other = nodes_[later_[node.later + j].node];
      updates_[node.update + j * (j + 1) / 2 + j] = other.diagonal;
      std::uint32_t at = other.later;
      for (std::uint32_t i = j + 1; i < node.later_count; ++i) {
        while (later_[at].node != later_[node.later + i].node) ++at;
        updates_[node.update + i * (i + 1) / 2 + j] = later_[at].block;
      }
    }
  }
}

void JointGraph::place_links(const JointElimination& plan, const Part& part) {
  const auto link = [&](std::uint32_t body, std::uint32_t p, std::uint32_t q) {
    const std::uint32_t first = std::min(p, q);
    const std::uint32_t second = std::max(p, q);
    links_.push_back({first, second, block_between(first, second), part.body + body});
  };
  for (std::uint32_t body = 0; body < part.body_count; ++body) {
    std::vector<std::uint32_t> places;
    for (const std::uint32_t i : plan.joints_of(body)) places.push_back(part.node + plan.place(i));
    if (plan.hub_of(body) != kNone) {
      const std::uint32_t hub = part.node + plan.place(plan.hub_of(body));
      for (const std::uint32_t p : places) link(body, p, hub);
      continue;
    }
    std::sort(places.begin(), places.end());
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = i + 1; j < places.size(); ++j) link(body, places[i], places[j]);
    }
  }
}

}  // namespace tandem::pbd
