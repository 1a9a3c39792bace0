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

/// The pose targets of one step and what serves them. Runs only where there are any.
///
/// A target is a row of the displacement channel. It is kept as what is still missing, e = target -
/// body. In a substep e first grows by h (target velocity - body velocity); a share of it is then
/// the displacement that the row asks for, and what other rows took back stays in e. Substep shares
/// compose exactly: 1 - (1 - s_n)^n = s.
class Targets {
 public:
  /// Take over this step's targets; forget bodies that cannot move.
  void begin_step(std::span<const PoseTarget> targets, std::span<SolverBody> bodies,
                  std::span<const BodyState> states, double dt);
  bool empty() const { return rows_.empty(); }
  int size() const { return static_cast<int>(rows_.size()); }

  /// Mark every body that is awake and joined or in touch with a targeted one, or with one that is
  /// marked already.
  /// @param island_of  by body
  void mark_islands(std::span<const std::uint32_t> island_of, std::span<const std::uint32_t> movers,
                    std::span<SolverBody> bodies);
  /// Mark every body that is awake and that joints hold to one that is marked for its gap, and the
  /// islands of those that are held for others.
  void mark_gaps(std::span<const ConstraintEdge> joints, std::span<const std::uint32_t> movers,
                 std::span<SolverBody> bodies);

 private:
  friend class GroupTargets;

  struct Row {
    std::uint32_t body = 0;
    TargetMotion motion = TargetMotion::WithBody;
    double share = 0.0;       ///< for each substep
    double step_share = 0.0;  ///< for the whole step
    Pose pose;                ///< Inertial: where the target is at the start of the step
    Twist twist;
    Vec3 e_x = Vec3::Zero();  ///< m, still missing
    Vec3 e_q = Vec3::Zero();  ///< rad, rotation vector, world
    Vec3 e_v = Vec3::Zero();  ///< m/s
    Vec3 e_w = Vec3::Zero();  ///< rad/s
  };
  std::vector<Row> rows_;
  std::vector<std::uint8_t> marked_;  ///< by island, or by set
  bool closes_gaps_ = false;
  Islands sets_;                       ///< by joints alone, where one has a gap
  std::vector<double> excess_;         ///< by set, see GroupTargets::limit_closing()
  std::vector<std::uint32_t> row_of_;  ///< by body; kNone without
};

/// Those of a group while it is solved, which others may be at the same time.
class GroupTargets {
 public:
  void select(Targets& all, const Group& group, std::span<const SolverBody> bodies);
  /// Room for groups of so many bodies.
  void reserve(std::size_t bodies) {
    rows_.reserve(bodies);
    saved_.reserve(bodies);
  }
  /// Whether some island of the group has a target.
  bool any() const { return !saved_.empty(); }

  /// v += s_n (v_target - v), likewise w. Adds the change of kinetic energy to `energy`. What a
  /// target moves by in the substep is added to what is missing.
  void agree_velocities(std::span<SolverBody> bodies, const PropsTable& props,
                        std::span<Correction> corrections, double h, ConsensusEnergy& energy);

  // A substep's displacement, once its velocities have been solved:
  /// What it starts from.
  void begin(std::span<const SolverBody> bodies);
  /// The rows: poses move towards where the targets are by the end of the substep.
  /// @param elapsed  s, from the start of the step to that end
  void pull(std::span<SolverBody> bodies, const PropsTable& props, double elapsed);
  /// What poses moved by becomes v_push and w_push, on which contacts are solved.
  void to_velocities(std::span<SolverBody> bodies, double h);
  /// Poses move by what contacts left of it.
  void to_poses(std::span<SolverBody> bodies, double h);
  /// Account for it.
  void end(std::span<const SolverBody> bodies, const PropsTable& props,
           std::span<Correction> corrections, const Vec3& gravity, ConsensusEnergy& energy);

 private:
  /// What closes gaps is displaced as a whole no faster than gaps may close. What its rows lack
  /// then is gap as well.
  void limit_closing(std::span<SolverBody> bodies);

  struct Saved {
    std::uint32_t body = 0;
    Vec3 x;
    Quat q;
    Vec3 v, w;
    Vec3 turn = Vec3::Zero();  ///< rad, world, what it was turned by
  };

  Targets* all_ = nullptr;
  std::vector<std::uint32_t> rows_;  ///< indices into those of all
  std::vector<Saved> saved_;         ///< bodies that are displaced
};

}  // namespace tandem::pbd
