// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/export.h"
#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/joint_gap.h"
#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

/// Keeps two points at a distance, rigidly or as a spring with damping, and within a range. A rope
/// is a range from 0 to its length without a spring.
/// C = |p_b - p_a| - rest_length [m];  n = (p_b - p_a) / |p_b - p_a|, dC/dx_b = n,
/// dC/dtheta_b = r_b x n, mirrored for a. Rigid limit (compliance 0): a rod. Infinitely soft: none.
/// Source: [macklin2016] Eqs. 18 and 26, rotation terms [mueller2020] Sec. 3.3.1. Differs:
/// gradients are taken at the start of the substep (see JointBlock).
class TANDEM_API DistanceJoint {
 public:
  static constexpr std::string_view kName = "distance_joint";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Compliant);
  static constexpr bool kGroupsAtOnce = true;

  struct Def {
    BodyId a = {};  ///< the invalid id stands for the world
    BodyId b = {};
    Vec3 anchor_a_l = Vec3::Zero();  ///< m, frame of a (world frame where a is the world)
    Vec3 anchor_b_l = Vec3::Zero();  ///< m, frame of b
    double rest_length = 0.0;        ///< m, >= 0
    double compliance = 0.0;         ///< m/N, >= 0; 0 = rigid; 1 / stiffness
    double damping = 0.0;            ///< N s/m, >= 0; without effect on a rigid joint
    bool elastic = true;             ///< false: only the range holds
    double min_length = 0.0;         ///< m, >= 0; rest_length lies in the range if `elastic`
    double max_length = kUnlimited;  ///< m, >= min_length
    double range_compliance = 0.0;   ///< m/N, >= 0, at both ends of the range; 0 = rigid
    double range_damping = 0.0;      ///< N s/m, >= 0; without effect on a rigid range
    double break_force = 0.0;        ///< N, >= 0; a larger force disables the joint; 0 = never
    bool enabled = true;
  };

  // CONFIGURATION PROPERTIES FOLLOW
  static void check(const World& world, const Def& def);
  explicit DistanceJoint(const Def& def) : def_(def) {}
  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return def_.a; }
  BodyId body_b() const { return def_.b; }

  // RUN TIME PROPERTIES FOLLOW
  void forgive(const SubstepContext& ctx);
  /// Turns violation from outside (set_pose, new limits) since the last step into a gap. @return
  /// whether there is one
  bool find_gap(const SubstepContext& ctx);
  void begin_substep(const SubstepContext& ctx);
  double project(const SubstepContext& ctx);
  void finish_velocity(const SubstepContext& ctx);
  void begin_displacement(const SubstepContext& ctx);
  double project_displacement(const SubstepContext& ctx);
  void end_displacement(const SubstepContext& ctx);
  void end_step(const SubstepContext& ctx);
  bool active() const { return def_.enabled; }
  /// Bodies do not sleep while a gap closes.
  bool actuated() const { return gap_.closes(); }
  bool force_driven() const {
    return (def_.elastic && def_.compliance > 0.0) || def_.range_compliance > 0.0;
  }
  double residual() const { return residual_; }
  double displacement_residual() const { return std::abs(displacement_residual_); }
  /// Force (N) along the joint in the last substep, positive = pushes the points apart. In the step
  /// in which it breaks: the force of the substep that broke it.
  double force() const { return force_; }
  Vec3 force_on_b() const { return force_ * n_; }  ///< N, world; its opposite acts on a
  /// Whether break_force disabled it; enable it to use it again.
  bool broken() const { return broken_ && !def_.enabled; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  struct Arms {
    SolverBody* a;
    SolverBody* b;
    Vec3 r_a, r_b, n;
    double length;
  };
  Arms arms(const SubstepContext& ctx, SolverBody& ground) const;
  /// The joint's force law as that of one coordinate, C.
  JointAxis axis() const;

  Def def_;
  double lambda_ = 0.0;      ///< N s^2
  double c_start_ = 0.0;     ///< m, C at the start of the substep
  Vec3 r_a_ = Vec3::Zero();  ///< m, world, lever arms and direction at the start of the substep
  Vec3 r_b_ = Vec3::Zero();
  Vec3 n_ = Vec3::Zero();
  double displacement_residual_ = 0.0;  ///< m, the part of C left by agreement and later rows
  JointGap gap_;                        ///< state of the gap in displacement_residual_
  double bound_ = 0.0;                  ///< m, value at which the displacement channel holds C
  double force_ = 0.0;
  double residual_ = 0.0;
  bool broken_ = false;
  bool broke_ = false;  ///< in this step
};

using DistanceJoints = TypedBlock<DistanceJoint>;

}  // namespace tandem::pbd
