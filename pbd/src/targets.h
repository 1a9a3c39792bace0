// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/solver.h"

namespace tandem::pbd {

/// The pose targets of one step and the channel that serves them. Runs only where there are any.
///
/// A target is kept as what is still missing: e = target - body, for pose and twist. In a substep e
/// first grows by h (target velocity - body velocity), a share of it is then closed, and what rows
/// blocked stays in e. Substep shares compose exactly: 1 - (1 - s_n)^n = s.
class Targets {
 public:
  /// Take over this step's targets; forget bodies that cannot move.
  void begin_step(std::span<const PoseTarget> targets, std::span<SolverBody> bodies,
                  std::span<const BodyState> states, double dt);
  bool empty() const { return rows_.empty(); }
  int size() const { return static_cast<int>(rows_.size()); }

  /// Mark every body that is awake and joined or in touch with a targeted one as part of the total
  /// channel.
  /// @param island_of  by body
  void mark_islands(std::span<const std::uint32_t> island_of, std::span<SolverBody> bodies);

  /// The methods below concern the bodies of this group, until the next call.
  /// @param parts  into how many the group's share is split over the step
  void select_group(std::uint32_t group, int parts, std::span<const SolverBody> bodies);
  /// Whether the group has a body in the total channel.
  bool selected() const { return !saved_.empty(); }

  /// Where the targets have moved to by the end of this substep. Call before agree_velocities.
  void advance(double h, double elapsed);
  /// v += s_n (v_target - v), likewise w. Adds the change of kinetic energy to `energy`.
  void agree_velocities(std::span<SolverBody> bodies, std::span<const BodyProps> props,
                        std::span<Correction> corrections, ConsensusEnergy& energy);

  /// Scale masses, move bodies to their targets, let the rows have their say, measure.
  /// @param heavier  see SolverOptions::heavier_where_shared
  void begin_total(std::span<SolverBody> bodies, bool heavier);
  void move_bodies(std::span<SolverBody> bodies, std::span<const BodyProps> props);
  void end_total(std::span<SolverBody> bodies, std::span<const BodyProps> props,
                 std::span<Correction> corrections, const Vec3& gravity, ConsensusEnergy& energy);

 private:
  struct Row {
    std::uint32_t body = 0;
    TargetMotion motion = TargetMotion::WithBody;
    double share = 0.0;       ///< for each part of the step
    double step_share = 0.0;  ///< for the whole step
    Pose pose;                ///< Inertial: where the target is at the start of the step
    Twist twist;
    Vec3 e_x = Vec3::Zero();  ///< m, still missing
    Vec3 e_q = Vec3::Zero();  ///< rad, rotation vector, world
    Vec3 e_v = Vec3::Zero();  ///< m/s
    Vec3 e_w = Vec3::Zero();  ///< rad/s
    double elapsed = 0.0;     ///< s since the start of the step
  };
  struct Saved {
    std::uint32_t body = 0;
    Vec3 x;
    Quat q;
    Vec3 v, w;
    double inv_mass = 0.0;
    Mat3 inv_inertia_w;
  };

  std::vector<Row> rows_;
  std::vector<std::uint32_t> in_group_;  ///< indices of the selected group's rows
  std::vector<Saved> saved_;             ///< the selected group's bodies in the total channel
  std::vector<std::uint8_t> marked_;     ///< by island: has a target
  std::vector<std::uint32_t> row_of_;    ///< by body; kNone without
};

}  // namespace tandem::pbd
