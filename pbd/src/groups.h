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
  bool driven = false;   ///< touches a kinematic body that moves
  bool alone = false;    ///< some row's block does not allow several groups at once
  std::size_t size = 0;  ///< set while it is formed
  std::span<const std::uint32_t> bodies;
};

/// Decides which islands sleep, and which need more substeps.
class Groups {
 public:
  /// Substeps are doubled at most this often.
  static constexpr std::uint8_t kMaxLevel = 5;

  struct Rule {
    int substeps = 0;                    ///< at level 0
    double sleep_after = 0.0;            ///< s, 0 = never
    double sleep_speed = 0.0;            ///< m/s
    double sleep_spin = 0.0;             ///< rad/s
    IslandCoupling* coupling = nullptr;  ///< null: no island is shared with another world
  };

  /// Wakes disturbed islands, sorts awake ones into groups by level and writes each body's island
  /// and group.
  /// @param movers   all bodies that may be movable, ascending; must live until settle()
  /// @param changed  bodies whose rows were changed
  void arrange(const Rule& rule, const Islands& islands, std::span<const std::uint32_t> movers,
               std::span<const std::uint32_t> changed, std::span<const ConstraintEdge> edges,
               std::span<const PoseTarget> targets, const PropsTable& props,
               std::span<BodyActivity> activity, std::span<SolverBody> bodies);
  /// Finds which groups are driven, and which ones are solved alone.
  /// @param any_driven  whether a kinematic body moves
  void note_apart(const ConstraintEdges& edges, bool any_driven,
                  std::span<const SolverBody> bodies);
  std::span<const Group> all() const { return groups_; }

  /// After the step: sets levels for the next one, and puts islands to sleep.
  /// @param wanted  by body: substeps that its rows want
  /// @param before  by body: state at the start of the step
  void settle(const Rule& rule, double dt, Workers& workers, const Islands& islands,
              std::span<const ConstraintEdge> edges, std::span<const double> wanted,
              std::span<const BodyState> before, const PropsTable& props,
              std::span<BodyActivity> activity, std::span<SolverBody> bodies);

 private:
  /// Sums over the bodies of each island. @return whether a kinematic body moves
  bool sum_islands(const Rule& rule, const Islands& islands, std::span<const BodyActivity> activity,
                   std::span<SolverBody> bodies);
  /// Clears joined_ of islands with a row that must not be swept again.
  void leave_out_joined(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);
  /// Wakes islands with changed rows, or with a body away from its target.
  void wake_islands(std::span<const std::uint32_t> changed, std::span<const PoseTarget> targets,
                    std::span<const SolverBody> bodies);
  void form_groups(const Rule& rule, const Islands& islands, const PropsTable& props,
                   std::span<BodyActivity> activity, std::span<SolverBody> bodies);
  void fill_groups(const Islands& islands, const PropsTable& props,
                   std::span<BodyActivity> activity, std::span<SolverBody> bodies);

  /// Keeps bodies awake that touch a kinematic body that moves.
  void disturb(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);
  /// Finds which bodies and islands are held, driven or sprung.
  void judge_rest(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies);

  std::span<const std::uint32_t> movers_;  ///< of this step; lists have other bodies too
  bool any_joined_ = false;                ///< some entry of joined_ is set
  /// By mover, in settle().
  enum class Rest : std::uint8_t { None, Stirs, Sleepy };
  detail::SparseArray<Rest> rest_;
  detail::SparseArray<IslandPart> islands_;  ///< by the island's lowest body
  /// By the island's lowest body: the rounded mean of its bodies' levels. A few refined bodies that
  /// fall on a heap do not refine the heap.
  detail::SparseArray<std::uint8_t> levels_;
  detail::SparseArray<std::uint8_t> joined_;     ///< by the island's lowest body, see Group
  detail::SparseArray<std::uint8_t> movable_;    ///< by body
  detail::SparseArray<std::uint8_t> sprung_;     ///< by body: springs or motors act on it
  detail::SparseArray<std::uint32_t> group_of_;  ///< by the island's lowest body
  std::vector<std::uint32_t> members_;           ///< bodies of all groups
  std::vector<Group> groups_;
};

}  // namespace tandem::pbd
