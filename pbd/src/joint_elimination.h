// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "joint_graph.h"

namespace tandem::pbd {

/// The order in which the nodes of one part of a JointGraph are eliminated, and the nodes that each
/// elimination couples. Joints are numbered like the edges, then hubs.
///
/// Minimum degree; ties by the longest time at that degree, then by number. This
/// eliminates a chain from both ends at once, which gives a processor independent work.
class JointElimination {
 public:
  explicit JointElimination(std::span<const JointGraph::Edge> edges);
  /// Call once. @return false if more than `most` block operations were needed
  bool run(std::size_t most);

  std::uint32_t node_count() const { return static_cast<std::uint32_t>(neighbours_.size()); }
  const std::vector<std::uint32_t>& bodies() const { return bodies_; }  ///< ascending
  /// Index of a body in bodies(); kNone for kNone.
  std::uint32_t local(std::uint32_t body) const;
  const std::vector<std::uint32_t>& joints_of(std::uint32_t local_body) const {
    return joints_of_[local_body];
  }
  /// The node of a hub body; kNone for other bodies.
  std::uint32_t hub_of(std::uint32_t local_body) const { return hub_of_[local_body]; }
  std::uint32_t body_of_hub(std::uint32_t node) const { return body_of_hub_[node - edges_.size()]; }
  const std::vector<std::uint32_t>& order() const { return order_; }      ///< nodes
  std::uint32_t place(std::uint32_t node) const { return place_[node]; }  ///< index in order()
  /// Places of the neighbours that the node at `place` has when it is eliminated, ascending.
  std::vector<std::uint32_t> later_places(std::uint32_t place) const;

 private:
  static constexpr std::uint32_t kNone = JointGraph::kNone;

  void find_bodies();
  void connect_all();

  std::span<const JointGraph::Edge> edges_;
  std::vector<std::uint32_t> bodies_;
  std::vector<std::vector<std::uint32_t>> joints_of_;   ///< by local body
  std::vector<std::uint32_t> hub_of_;                   ///< by local body
  std::vector<std::uint32_t> body_of_hub_;              ///< local indices
  std::vector<std::vector<std::uint32_t>> neighbours_;  ///< ascending
  std::vector<int> supports_;   ///< ends of a joint that respond to all its rows
  std::vector<int> hubs_left_;  ///< hubs of a joint not yet eliminated
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> place_;
  std::vector<std::vector<std::uint32_t>> later_of_;
};

}  // namespace tandem::pbd
