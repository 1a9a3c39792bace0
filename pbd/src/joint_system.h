// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "joint_part.h"

namespace tandem::pbd {

/// The rows of all joints as sparse systems, one per part of the joint graph. Scratch memory only.
class JointSystem {
 public:
  /// Plans for the active joints; allocates. Joints are taken in the order of their bodies if these
  /// have an order of their own, else by slot.
  void build(std::span<const JointRecord> records, std::span<const SolverBody> bodies,
             const BodyOrder& order);
  /// Whether the plan still fits: the active joints, which of their bodies can move, and the
  /// reserved rows.
  /// @pre no joint was added or removed since build()
  bool fits(std::span<const JointRecord> records, std::span<const SolverBody> bodies) const;
  /// Finds which parts neither store nor supply energy.
  void note_passive(std::span<const JointRecord> records);
  /// Sorts parts by group for for_parts().
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

  /// Takes gradients and force laws from the current poses; multipliers start at 0.
  void begin(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx,
             JointChannel channel);
  /// One Newton iteration. Returns an estimate of the remaining error of bodies, m.
  double iterate(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx);
  /// Call after velocities have taken over the moves of bodies.
  void finish_projection(std::uint32_t part, std::span<JointRecord> records,
                         const SubstepContext& ctx);
  /// Writes the forces of the substep to the records; overloaded joints break.
  void finish(std::uint32_t part, std::span<JointRecord> records, const SubstepContext& ctx);

 private:
  struct GroupPart {
    std::uint32_t group, part;
  };

  JointPart part_of(std::uint32_t p, std::span<JointRecord> records, const SubstepContext& ctx);

  JointData data_;
  std::vector<JointProgress> progress_;  ///< by part
  std::vector<std::uint8_t> passive_;    ///< by part: nothing stores or supplies energy
  std::vector<GroupPart> order_;
};

}  // namespace tandem::pbd
