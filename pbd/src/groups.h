// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "constraint_edges.h"
#include "islands.h"
#include "tandem/pbd/body.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/island_coupling.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/props_table.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// Bodies that are solved together, with the same substeps: whole islands.
struct Group {
  std::uint8_t level = 0;
  int substeps = 0;
  double share = 1.0;  ///< of all bodies of the level
  int islands = 0;
  bool locked = false;   ///< some body has a locked axis
  bool joined = false;   ///< one island, where joints and later rows share bodies
  bool driven = false;   ///< something immovable that moves is in touch with it
  bool alone = false;    ///< some row is of a block that is asked for one group at a time
  std::size_t size = 0;  ///< while it is formed
  std::span<const std::uint32_t> bodies;
};

/// Which islands sleep, and which need more substeps than the others.
class Groups {
 public:
  /// Substeps are doubled this often at most.
  static constexpr std::uint8_t kMaxLevel = 5;

  struct Rule {
    int substeps = 0;                    ///< at level 0
    double sleep_after = 0.0;            ///< s, 0 = never
    double sleep_speed = 0.0;            ///< m/s
    double sleep_spin = 0.0;             ///< rad/s
    IslandCoupling* coupling = nullptr;  ///< null: no island goes on in another world
  };

  /// Wake what is disturbed, put the others into groups by level and write each body's island and
  /// group.
  /// @param movers   all that may be movable, ascending; also of settle() after it
  /// @param changed  bodies whose rows were changed
  void arrange(const Rule& rule, const Islands& islands, std::span<const std::uint32_t> movers,
               std::span<const std::uint32_t> changed, std::span<const ConstraintEdge> edges,
               std::span<const PoseTarget> targets, const PropsTable& props,
               std::span<BodyActivity> activity, std::span<SolverBody> bodies);
  /// Which groups are driven, and which ones are solved alone.
  /// @param any_driven  whether something immovable moves
  void note_apart(const ConstraintEdges& edges, bool any_driven,
                  std::span<const SolverBody> bodies);
  std::span<const Group> all() const { return groups_; }

  /// After the step: levels for the next one, and who falls asleep.
  /// @param wanted  by body: substeps that its rows ask for
  /// @param before  by body: where the step began
  void settle(const Rule& rule, double dt, Workers& workers, const Islands& islands,
              std::span<const ConstraintEdge> edges, std::span<const double> wanted,
              std::span<const BodyState> before, const PropsTable& props,
              std::span<BodyActivity> activity, std::span<SolverBody> bodies);

 private:
  /// What the bodies of each island say of it. @return whether something immovable moves
  bool sum_islands(const Rule& rule, const Islands& islands, std::span<const BodyActivity> activity,
                   std::span<SolverBody> bodies);
  /// Of the islands where joints and contacts meet those with a row that is not swept again.
  void leave_out_joined(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);
  /// Whose rows were changed, and who is told to be elsewhere.
  void wake_islands(std::span<const std::uint32_t> changed, std::span<const PoseTarget> targets,
                    std::span<const SolverBody> bodies);
  void form_groups(const Rule& rule, const Islands& islands, const PropsTable& props,
                   std::span<BodyActivity> activity, std::span<SolverBody> bodies);
  void fill_groups(const Islands& islands, const PropsTable& props,
                   std::span<BodyActivity> activity, std::span<SolverBody> bodies);

  /// What an immovable body that moves is in touch with does not sleep.
  void disturb(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);
  /// What is held, driven or sprung.
  void judge_rest(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);

  std::span<const std::uint32_t> movers_;  ///< of this step; what else is in the lists is not read
  bool any_joined_ = false;                ///< of joined_
  /// By mover, of settle().
  enum class Rest : std::uint8_t { None, Stirs, Sleepy };
  detail::SparseArray<Rest> rest_;
  detail::SparseArray<IslandPart> islands_;  ///< by the index of the lowest body
  /// Likewise: the mean of its bodies' levels, rounded. A few refined bodies that fall on a heap do
  /// not refine the heap.
  detail::SparseArray<std::uint8_t> levels_;
  detail::SparseArray<std::uint8_t> joined_;     ///< likewise, see Group
  detail::SparseArray<std::uint8_t> movable_;    ///< by body
  detail::SparseArray<std::uint8_t> sprung_;     ///< by body: springs or motors act on it
  detail::SparseArray<std::uint32_t> group_of_;  ///< by the index of the lowest body of an island
  std::vector<std::uint32_t> members_;           ///< of all groups
  std::vector<Group> groups_;
};

}  // namespace tandem::pbd
