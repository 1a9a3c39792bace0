// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "groups.h"
#include "islands.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/props_table.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/solver.h"

namespace tandem::pbd {

/// The pose targets of one step, and their rows. Runs only if there are any.
///
/// A target is a row of the displacement channel. Its state is the remaining error e = target -
/// body. In a substep e first grows by h (target velocity - body velocity); a share of it is the
/// displacement that the row asks for, and the part that other rows took back stays in e. Substep
/// shares compose exactly: 1 - (1 - s_n)^n = s.
class Targets {
 public:
  /// Takes this step's targets; drops those of immovable bodies.
  void begin_step(std::span<const PoseTarget> targets, std::span<SolverBody> bodies,
                  std::span<const BodyState> states, double dt);
  bool empty() const { return rows_.empty(); }
  int size() const { return static_cast<int>(rows_.size()); }

  /// Marks every awake body in an island with a targeted or marked body.
  /// @param island_of  by body
  void mark_islands(std::span<const std::uint32_t> island_of, std::span<const std::uint32_t> movers,
                    std::span<SolverBody> bodies);
  /// Marks every awake body that joints connect to one marked for its gap, and the islands of
  /// bodies that are held.
  void mark_gaps(std::span<const ConstraintEdge> joints, std::span<const std::uint32_t> movers,
                 std::span<SolverBody> bodies);

 private:
  friend class GroupTargets;

  struct Row {
    std::uint32_t body = 0;
    TargetMotion motion = TargetMotion::WithBody;
    double share = 0.0;       ///< per substep
    double step_share = 0.0;  ///< for the whole step
    Pose pose;                ///< Inertial: target at the start of the step
    Twist twist;
    Vec3 e_x = Vec3::Zero();  ///< m, remaining error
    Vec3 e_q = Vec3::Zero();  ///< rad, rotation vector, world
    Vec3 e_v = Vec3::Zero();  ///< m/s
    Vec3 e_w = Vec3::Zero();  ///< rad/s
  };
  std::vector<Row> rows_;
  std::vector<std::uint8_t> marked_;  ///< by island, or by set
  bool closes_gaps_ = false;
  Islands sets_;                       ///< sets by joints alone, where one has a gap
  std::vector<double> excess_;         ///< by set, see GroupTargets::limit_closing()
  std::vector<std::uint32_t> row_of_;  ///< by body; kNone if it has none
};

/// The targets of a group while it is solved; other groups may be solved at the same time.
class GroupTargets {
 public:
  void select(Targets& all, const Group& group, std::span<const SolverBody> bodies);
  /// Reserves for groups of so many bodies.
  void reserve(std::size_t bodies) {
    rows_.reserve(bodies);
    saved_.reserve(bodies);
  }
  /// Whether some island of the group has a target.
  bool any() const { return !saved_.empty(); }

  /// v += s_n (v_target - v), and w likewise. Adds the change of kinetic energy to `energy`, and
  /// the target's motion in the substep to the remaining error.
  void agree_velocities(std::span<SolverBody> bodies, const PropsTable& props,
                        std::span<Correction> corrections, double h, ConsensusEnergy& energy);

  // Displacement of a substep, after its velocities have been solved:
  /// Stores the start.
  void begin(std::span<const SolverBody> bodies);
  /// The rows: move poses towards the targets' poses at the end of the substep.
  /// @param elapsed  s, from the start of the step to that end
  void pull(std::span<SolverBody> bodies, const PropsTable& props, double elapsed);
  /// Turns the moves of poses into v_push and w_push, on which contacts are solved.
  void to_velocities(std::span<SolverBody> bodies, double h);
  /// Moves poses by what contacts left of these.
  void to_poses(std::span<SolverBody> bodies, double h);
  /// Accounts for the displacement.
  void end(std::span<const SolverBody> bodies, const PropsTable& props,
           std::span<Correction> corrections, const Vec3& gravity, ConsensusEnergy& energy);

 private:
  /// Limits the displacement of sets that close gaps to the closing speed. The part that their rows
  /// then lack becomes gap too.
  void limit_closing(std::span<SolverBody> bodies);

  struct Saved {
    std::uint32_t body = 0;
    Vec3 x;
    Quat q;
    Vec3 v, w;
    Vec3 turn = Vec3::Zero();  ///< rad, world, rotation by displacement
  };

  Targets* all_ = nullptr;
  std::vector<std::uint32_t> rows_;  ///< indices into the rows of all groups
  std::vector<Saved> saved_;         ///< bodies that are displaced
};

}  // namespace tandem::pbd
