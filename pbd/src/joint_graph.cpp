// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_graph.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

namespace tandem::pbd {
namespace {

/// A body with more joints than this becomes an unknown of its own.
constexpr std::size_t kHubDegree = 8;
constexpr int kHubRows = 6;
/// Block operations that fill-in may cost for each node: a lattice of 30 x 30 bodies takes 300.
/// Loops that are cut part by a centimetre and lose energy, so that is for what would take seconds.
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
  /// @return whether they were apart
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
  // Joints by island, in the order of the lowest joint of each.
  std::vector<std::vector<Edge>> groups;
  std::vector<std::uint32_t> group_of(body_count, kNone);
  for (const Edge& edge : edges) {
    const std::uint32_t body = edge.b != kNone ? edge.b : edge.a;
    if (body == kNone) continue;  // neither end can move
    std::uint32_t& group = group_of[islands.root(body)];
    if (group == kNone) {
      group = static_cast<std::uint32_t>(groups.size());
      groups.emplace_back();
    }
    groups[group].push_back(edge);
  }
  for (const std::vector<Edge>& group : groups) {
    if (add_part(group, true)) continue;
    // Too many loops: a spanning tree together, what closes a loop one by one.
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
  // Bodies and hubs.
  std::vector<std::uint32_t> bodies;
  std::size_t fixed_ends = 0;
  for (const Edge& edge : edges) {
    if (edge.a != kNone) bodies.push_back(edge.a);
    if (edge.b != kNone) bodies.push_back(edge.b);
    if (edge.a == kNone || edge.b == kNone) ++fixed_ends;
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  const auto local = [&](std::uint32_t body) {
    if (body == kNone) return kNone;
    return static_cast<std::uint32_t>(std::lower_bound(bodies.begin(), bodies.end(), body) -
                                      bodies.begin());
  };
  std::vector<std::vector<std::uint32_t>> joints_of(bodies.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (const std::uint32_t body : {edges[i].a, edges[i].b}) {
      if (body != kNone) joints_of[local(body)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::vector<std::uint32_t> hub_node(bodies.size(), kNone);
  auto count = static_cast<std::uint32_t>(edges.size());
  std::vector<std::size_t> body_of_hub;
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (joints_of[body].size() <= kHubDegree) continue;
    hub_node[body] = count++;
    body_of_hub.push_back(body);
  }

  // Neighbours, how many ends a joint has that answer to all its rows, and how many hubs that are
  // not eliminated yet. Before them a joint needs such an end for its pivots.
  std::vector<std::set<std::uint32_t>> neighbours(count);
  std::vector<int> supports(count, 0);
  std::vector<int> hubs_left(count, 0);
  const auto is_ready = [&](std::uint32_t i) { return supports[i] > 0 || hubs_left[i] == 0; };
  const auto connect = [&](std::uint32_t i, std::uint32_t j) {
    if (i == j) return;
    neighbours[i].insert(j);
    neighbours[j].insert(i);
  };
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (const auto& [body, turns] :
         {std::pair(edges[i].a, edges[i].turns_a), std::pair(edges[i].b, edges[i].turns_b)}) {
      if (body == kNone) continue;
      const bool hub = hub_node[local(body)] != kNone;
      if (hub) ++hubs_left[i];
      if (!hub && turns) ++supports[i];
    }
  }
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    for (const std::uint32_t i : joints_of[body]) {
      if (hub_node[body] != kNone) {
        connect(i, hub_node[body]);
      } else {
        for (const std::uint32_t j : joints_of[body]) connect(i, j);
      }
    }
  }

  // Minimum degree; of those with the same that which has had it for longest, then the lowest
  // number: a chain is eliminated from its ends at once, so that a processor finds work that does
  // not wait for what it does already.
  std::vector<std::size_t> degree(count, 0);
  std::vector<std::size_t> since(count, 0);
  std::size_t now = 0;
  std::set<std::tuple<std::size_t, std::size_t, std::uint32_t>> queue;
  const auto enqueue = [&](std::uint32_t i) {
    if (neighbours[i].size() != degree[i]) since[i] = now;
    degree[i] = neighbours[i].size();
    if (is_ready(i)) queue.insert({degree[i], since[i], i});
  };
  for (std::uint32_t i = 0; i < count; ++i) enqueue(i);
  std::vector<std::uint32_t> order;
  std::vector<std::vector<std::uint32_t>> later_of(count);
  std::vector<std::uint8_t> done(count, 0);
  std::size_t update_count = 0;
  while (!queue.empty()) {
    const std::uint32_t node = std::get<2>(*queue.begin());
    queue.erase(queue.begin());
    ++now;
    done[node] = 1;
    order.push_back(node);
    later_of[node].assign(neighbours[node].begin(), neighbours[node].end());
    const std::vector<std::uint32_t>& rest = later_of[node];
    update_count += rest.size() * (rest.size() + 1) / 2;
    if (may_refuse && update_count > kUpdatesPerNode * count) return false;
    for (const std::uint32_t i : rest) queue.erase({degree[i], since[i], i});
    for (const std::uint32_t i : rest) {
      neighbours[i].erase(node);
      for (const std::uint32_t j : rest) connect(i, j);
    }
    if (node >= edges.size()) {
      for (const std::uint32_t i : joints_of[body_of_hub[node - edges.size()]]) --hubs_left[i];
    }
    for (const std::uint32_t i : rest) enqueue(i);
  }

  // Where everything lies.
  Part part{};
  part.node = static_cast<std::uint32_t>(nodes_.size());
  part.node_count = count;
  part.body = static_cast<std::uint32_t>(bodies_.size());
  part.body_count = static_cast<std::uint32_t>(bodies.size());
  part.link = static_cast<std::uint32_t>(links_.size());
  part.value = value_count_;
  part.regular = edges.size() + (fixed_ends == 0 ? 1 : 0) == bodies.size();
  part.points = count == edges.size() &&
                std::all_of(edges.begin(), edges.end(), [](const Edge& e) { return e.point; });
  bodies_.insert(bodies_.end(), bodies.begin(), bodies.end());
  std::vector<std::uint32_t> place(count);
  for (std::uint32_t k = 0; k < count; ++k) place[order[k]] = k;
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    hubs_.push_back(hub_node[body] != kNone ? 1 : 0);
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    Node node;
    const std::uint32_t i = order[k];
    if (i < edges.size()) {
      node.joint = edges[i].joint;
      node.rows = edges[i].rows;
      if (edges[i].a != kNone) node.slot_a = part.body + local(edges[i].a);
      if (edges[i].b != kNone) node.slot_b = part.body + local(edges[i].b);
    } else {
      node.rows = kHubRows;
      for (std::uint32_t body = 0; body < bodies.size(); ++body) {
        if (hub_node[body] == i) node.slot_b = part.body + body;
      }
    }
    node.diagonal = value_count_;
    value_count_ += static_cast<std::uint32_t>(node.rows * node.rows);
    node.right = right_count_;
    right_count_ += static_cast<std::uint32_t>(node.rows);
    nodes_.push_back(node);
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    Node& node = nodes_[part.node + k];
    node.later = static_cast<std::uint32_t>(later_.size());
    std::vector<std::uint32_t> places;
    for (const std::uint32_t i : later_of[order[k]]) places.push_back(place[i]);
    std::sort(places.begin(), places.end());
    for (const std::uint32_t p : places) {
      later_.push_back({part.node + p, value_count_, nodes_[part.node + p].right});
      value_count_ += static_cast<std::uint32_t>(node.rows * nodes_[part.node + p].rows);
    }
    node.later_count = static_cast<std::uint32_t>(places.size());
  }
  const auto block_between = [&](std::uint32_t earlier, std::uint32_t later_node) {
    const Node& node = nodes_[earlier];
    for (std::uint32_t l = node.later; l < node.later + node.later_count; ++l) {
      if (later_[l].node == later_node) return later_[l].block;
    }
    return kNone;
  };
  for (std::uint32_t k = 0; k < count; ++k) {
    Node& node = nodes_[part.node + k];
    node.update = static_cast<std::uint32_t>(updates_.size());
    for (std::uint32_t i = 0; i < node.later_count; ++i) {
      for (std::uint32_t j = 0; j < i; ++j) {
        updates_.push_back(block_between(later_[node.later + j].node, later_[node.later + i].node));
      }
      updates_.push_back(nodes_[later_[node.later + i].node].diagonal);
    }
  }
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    std::vector<std::uint32_t> places;
    for (const std::uint32_t i : joints_of[body]) places.push_back(part.node + place[i]);
    if (hub_node[body] != kNone) {
      const std::uint32_t hub = part.node + place[hub_node[body]];
      for (const std::uint32_t p : places) {
        const std::uint32_t first = std::min(p, hub);
        const std::uint32_t second = std::max(p, hub);
        links_.push_back({first, second, block_between(first, second), part.body + body});
      }
      continue;
    }
    std::sort(places.begin(), places.end());
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (std::size_t j = i + 1; j < places.size(); ++j) {
        links_.push_back(
            {places[i], places[j], block_between(places[i], places[j]), part.body + body});
      }
    }
  }
  part.link_count = static_cast<std::uint32_t>(links_.size()) - part.link;
  part.value_count = value_count_ - part.value;
  parts_.push_back(part);
  return true;
}

}  // namespace tandem::pbd
