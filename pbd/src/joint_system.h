// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "joint_part.h"

namespace tandem::pbd {

/// The rows of all joints as one sparse system for each part of the joint graph: what is needed to
/// project them together. Scratch memory only.
class JointSystem {
 public:
  /// Plan for the joints that are active; allocates. Where bodies have an order of their own,
  /// joints are taken by the order of their bodies, else by slot.
  void build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
             const BodyOrder& order);
  /// Whether the plan still fits: the joints that are active, which of their bodies can move, and
  /// rows that it has room for.
  /// @pre no joint has come or gone since build()
  bool fits(std::span<const JointRecord> records, std::span<const SolverBody> bodies) const;
  /// Find which parts store or supply no energy.
  void note_passive(std::span<const JointRecord> records);
  /// Sort parts by group for for_parts().
  void sort_groups(std::span<const SolverBody> bodies);

  void for_parts(std::uint32_t group, bool reverse, auto&& visit) {
    const auto before = [](const GroupPart& part, std::uint32_t g) { return part.group < g; };
    const auto first = std::lower_bound(order_.begin(), order_.end(), group, before);
    const auto last = std::find_if(first, order_.end(),
                                   [&](const GroupPart& part) { return part.group != group; });
    const std::ptrdiff_t count = last - first;
    for (std::ptrdiff_t k = 0; k < count; ++k) visit(first[reverse ? count - 1 - k : k].part);
  }
  std::uint32_t part_count() const {
    return static_cast<std::uint32_t>(data_.graph.parts().size());
  }
  bool is_shared(std::uint32_t part, std::span<const SolverBody> bodies) const;

  /// Take gradients and force laws from the poses as they are; multipliers start at 0.
  void begin(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx,
             JointChannel channel);
  /// One Newton iteration. Returns how far the bodies may still be from where they belong, m.
  double iterate(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx);
  /// Velocities have learnt what bodies were moved by.
  void finish_projection(std::uint32_t part, std::span<JointRecord> records,
                         const SubstepContext& ctx);
  /// Forces of the substep into the records; joints that they are too much for break.
  void finish(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx);

 private:
  struct GroupPart {
    std::uint32_t group, part;
  };

  JointPart part_of(std::uint32_t p, std::span<JointRecord> records, const SubstepContext& ctx);

  JointData data_;
  std::vector<JointProgress> progress_;  ///< by part
  std::vector<std::uint8_t> passive_;    ///< by part: nothing supplies energy
  std::vector<GroupPart> order_;
};

}  // namespace tandem::pbd
