// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tandem::pbd {

class JointElimination;

/// The plan of a sparse block elimination over joints: the blocks, the order of elimination, and
/// the blocks that each elimination changes. Rebuilt when joints are added or removed. Spare room
/// for rows does not affect results.
///
/// A node is a joint (its rows) or a hub: a body with so many joints that coupling all of them
/// would cost more than keeping the body's six unknowns. Two joints are neighbours if they share a
/// body that is no hub; a hub is a neighbour of its joints. Parts are solved one after the other.
/// Joints of different parts share a body only if a loop was cut because its fill-in would cost too
/// much.
class JointGraph {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Input of the plan. Immovable bodies are kNone.
  struct Edge {
    std::uint32_t joint, a, b;
    int rows;            ///< largest number
    bool point = false;  ///< always exactly the three rows of a point
    /// No axis of the body's rotation is locked: it responds to all rows.
    bool turns_a = true, turns_b = true;
  };
  struct Node {
    std::uint32_t joint = kNone;                   ///< kNone for a hub
    std::uint32_t slot_a = kNone, slot_b = kNone;  ///< index into bodies(); a hub's own is slot_b
    std::uint32_t diagonal = 0;                    ///< index into the values
    std::uint32_t later = 0, later_count = 0;      ///< index into later()
    std::uint32_t update = 0;  ///< index into updates(), (count + 1) count / 2 entries
    std::uint32_t right = 0;   ///< index into the right-hand side
    int rows = 0;              ///< largest number
    bool point = false;        ///< see Edge
  };
  /// A neighbour that is eliminated later, and the block (its rows x the node's) between them.
  struct Later {
    std::uint32_t node, block, right;
  };
  /// Two nodes coupled by a body: `later` is eliminated after `earlier`.
  struct Link {
    std::uint32_t earlier, later, block, slot;
  };
  struct Part {
    std::uint32_t node, node_count;
    std::uint32_t body, body_count;
    std::uint32_t link, link_count;
    std::uint32_t value, value_count;
    bool regular;  ///< no loop and at most one path to an immovable body: rows are independent
    bool points;   ///< all nodes are point joints, see Edge
  };

  void build(std::span<const Edge> edges);
  /// Renames bodies to `name(body)`.
  void rename_bodies(auto&& name) {
    for (std::uint32_t& body : bodies_) body = name(body);
  }

  const std::vector<Node>& nodes() const { return nodes_; }  ///< by part, in elimination order
  const std::vector<Later>& later() const { return later_; }
  const std::vector<std::uint32_t>& updates() const { return updates_; }
  const std::vector<Link>& links() const { return links_; }
  /// By part, ascending by the numbers in the edges.
  const std::vector<std::uint32_t>& bodies() const { return bodies_; }
  const std::vector<std::uint8_t>& hubs() const { return hubs_; }  ///< by slot
  const std::vector<Part>& parts() const { return parts_; }
  std::uint32_t value_count() const { return value_count_; }
  std::uint32_t right_count() const { return right_count_; }

 private:
  /// @return whether the fill-in stayed within the limit for this size
  bool add_part(std::span<const Edge> edges, bool may_refuse);
  void place_nodes(std::span<const Edge> edges, const JointElimination& plan, const Part& part);
  void place_blocks(const JointElimination& plan, const Part& part);
  void place_updates(const Part& part);
  void place_links(const JointElimination& plan, const Part& part);
  /// Offset of the block of two nodes, earlier one first; kNone if there is none.
  std::uint32_t block_between(std::uint32_t earlier, std::uint32_t later_node) const;

  std::vector<Node> nodes_;
  std::vector<Later> later_;
  std::vector<std::uint32_t> updates_;
  std::vector<Link> links_;
  std::vector<std::uint32_t> bodies_;
  std::vector<std::uint8_t> hubs_;
  std::vector<Part> parts_;
  std::uint32_t value_count_ = 0;
  std::uint32_t right_count_ = 0;
};

}  // namespace tandem::pbd
