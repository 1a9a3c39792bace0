// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/typed_block.h"

namespace tandem::pbd {

/// Holds a point of body b at a point of body a.
/// C = p_b - p_a [m, three rows];  dC/dx_b = E, dC/dtheta_b = -[r_b], mirrored for a.
/// Rigid limit (compliance 0): the 3x3 block is solved exactly. Infinitely soft limit: no effect.
/// Source: [mueller2020] Sec. 3.3.1 and 3.4. Differs: the three rows are solved as a block instead
/// of along C / |C|; lever arms are those of the substep's start, which makes a converged step that
/// of SHAKE [ryckaert1977]: a swinging rod then keeps its energy, where lever arms taken at the
/// predicted pose lose more than half of it in 5 s. arm_blend() goes over to those where
/// the joint's force is too large for the step.
class BallJoint {
 public:
  static constexpr std::string_view kName = "ball_joint";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Joint);

  struct Def {
    BodyId a;  ///< the invalid id stands for the world
    BodyId b;
    Vec3 anchor_a_l = Vec3::Zero();  ///< m, frame of a (world frame where a is the world)
    Vec3 anchor_b_l = Vec3::Zero();  ///< m, frame of b
    double compliance = 0.0;         ///< m/N, >= 0; 0 = rigid
    double damping = 0.0;            ///< N s/m, >= 0; without effect on a rigid joint
  };

  // CONFIGURATION PROPERTIES FOLLOW
  static void check(const World& world, const Def& def);
  explicit BallJoint(const Def& def) : def_(def) {}
  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return def_.a; }
  BodyId body_b() const { return def_.b; }

  // RUN TIME PROPERTIES FOLLOW
  void begin_substep(const SubstepContext& ctx);
  double project(const SubstepContext& ctx);
  void want_substeps(const SubstepContext& ctx, std::span<double> wanted) const;
  void begin_total(const SubstepContext& ctx);
  void project_total(const SubstepContext& ctx);
  void end_total(const SubstepContext& ctx);
  void end_step(const SubstepContext& ctx);
  double residual() const { return residual_; }
  double total_residual() const { return gap_.norm(); }
  /// Force (N, world) on body b in the last substep.
  const Vec3& force() const { return force_; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  struct Arms {
    SolverBody* a;
    SolverBody* b;
    Vec3 r_a, r_b, c;  ///< lever arms and C, m, world
  };
  Arms arms(const SubstepContext& ctx, SolverBody& ground) const;

  Def def_;
  Vec3 lambda_ = Vec3::Zero();   ///< N s^2
  Vec3 c_start_ = Vec3::Zero();  ///< m, C at the start of the substep
  Vec3 r_a_ = Vec3::Zero();      ///< m, world, lever arms at the start of the substep
  Vec3 r_b_ = Vec3::Zero();
  double blend_a_ = 0.0;  ///< see arm_blend()
  double blend_b_ = 0.0;
  Vec3 total_ = Vec3::Zero();  ///< N s^2, multiplier of the total channel
  Vec3 gap_ = Vec3::Zero();    ///< m, the part of C that agreement left behind
  Vec3 bound_ = Vec3::Zero();  ///< m, where the total channel holds C
  Vec3 force_ = Vec3::Zero();
  double residual_ = 0.0;
};

using BallJoints = TypedBlock<BallJoint>;

/// A ball joint at the world point `anchor_w` (m) as the bodies stand now.
BallJoint::Def ball_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w);

}  // namespace tandem::pbd
