// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_elimination.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>

namespace tandem::pbd {
namespace {

/// A body with more joints becomes a hub, an unknown of its own.
constexpr std::size_t kHubDegree = 8;

}  // namespace

JointElimination::JointElimination(std::span<const JointGraph::Edge> edges) : edges_(edges) {
  find_bodies();
  connect_all();
}

void JointElimination::find_bodies() {
  for (const JointGraph::Edge& edge : edges_) {
    if (edge.a != kNone) bodies_.push_back(edge.a);
    if (edge.b != kNone) bodies_.push_back(edge.b);
  }
  std::sort(bodies_.begin(), bodies_.end());
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
  joints_of_.resize(bodies_.size());
  for (std::uint32_t i = 0; i < edges_.size(); ++i) {
    for (const std::uint32_t body : {edges_[i].a, edges_[i].b}) {
      if (body != kNone) joints_of_[local(body)].push_back(i);
    }
  }
  hub_of_.assign(bodies_.size(), kNone);
  for (std::uint32_t body = 0; body < bodies_.size(); ++body) {
    if (joints_of_[body].size() <= kHubDegree) continue;
    hub_of_[body] = static_cast<std::uint32_t>(edges_.size() + body_of_hub_.size());
    body_of_hub_.push_back(body);
  }
}

std::uint32_t JointElimination::local(std::uint32_t body) const {
  if (body == kNone) return kNone;
  return static_cast<std::uint32_t>(std::lower_bound(bodies_.begin(), bodies_.end(), body) -
                                    bodies_.begin());
}

void JointElimination::connect_all() {
  const std::size_t count = edges_.size() + body_of_hub_.size();
  neighbours_.resize(count);
  supports_.assign(count, 0);
  hubs_left_.assign(count, 0);
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    for (const auto& [body, turns] :
         {std::pair(edges_[i].a, edges_[i].turns_a), std::pair(edges_[i].b, edges_[i].turns_b)}) {
      if (body == kNone) continue;
      const bool hub = hub_of_[local(body)] != kNone;
      if (hub) ++hubs_left_[i];
      if (!hub && turns) ++supports_[i];
    }
  }
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    const std::uint32_t hub = hub_of_[body];
    for (const std::uint32_t i : joints_of_[body]) {
      std::vector<std::uint32_t>& own = neighbours_[i];
      if (hub == kNone) {
        std::copy_if(joints_of_[body].begin(), joints_of_[body].end(), std::back_inserter(own),
                     [i](std::uint32_t j) { return j != i; });
      } else {
        own.push_back(hub);
        neighbours_[hub].push_back(i);
      }
    }
  }
  for (std::vector<std::uint32_t>& own : neighbours_) {
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
  }
}

bool JointElimination::run(std::size_t most) {
  const std::uint32_t count = node_count();
  std::vector<std::size_t> degree(count, 0);
  std::vector<std::size_t> since(count, 0);
  std::size_t now = 0;
  // Degree, time since it has it, node. Entries with an outdated degree are skipped.
  using Place = std::tuple<std::size_t, std::size_t, std::uint32_t>;
  std::priority_queue<Place, std::vector<Place>, std::greater<>> queue;
  std::vector<bool> queued(count, false);
  const auto enqueue = [&](std::uint32_t i) {
    const bool same = neighbours_[i].size() == degree[i];
    if (!same) since[i] = now;
    degree[i] = neighbours_[i].size();
    // A joint needs an end that responds to all its rows before its hubs, for its pivots.
    if (supports_[i] == 0 && hubs_left_[i] > 0) return;
    if (!same || !queued[i]) queue.push({degree[i], since[i], i});
    queued[i] = true;
  };
  for (std::uint32_t i = 0; i < count; ++i) enqueue(i);
  later_of_.resize(count);
  std::size_t updates = 0;
  std::vector<std::uint32_t> merged;
  while (!queue.empty()) {
    const auto [had, from, next] = queue.top();
    const std::uint32_t node = next;
    queue.pop();
    if (!queued[node] || had != degree[node] || from != since[node]) continue;
    queued[node] = false;
    ++now;
    order_.push_back(node);
    later_of_[node] = std::move(neighbours_[node]);
    const std::vector<std::uint32_t>& rest = later_of_[node];
    updates += rest.size() * (rest.size() + 1) / 2;
    if (updates > most) return false;
    for (const std::uint32_t i : rest) {
      merged.clear();
      std::set_union(neighbours_[i].begin(), neighbours_[i].end(), rest.begin(), rest.end(),
                     std::back_inserter(merged));
      std::erase_if(merged, [i, node](std::uint32_t j) { return j == i || j == node; });
      neighbours_[i].swap(merged);
    }
    if (node >= edges_.size()) {
      for (const std::uint32_t i : joints_of_[body_of_hub(node)]) --hubs_left_[i];
    }
    for (const std::uint32_t i : rest) enqueue(i);
  }
  place_.resize(count);
  for (std::uint32_t k = 0; k < count; ++k) place_[order_[k]] = k;
  return true;
}

std::vector<std::uint32_t> JointElimination::later_places(std::uint32_t place) const {
  std::vector<std::uint32_t> places;
  for (const std::uint32_t i : later_of_[order_[place]]) places.push_back(place_[i]);
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace tandem::pbd
