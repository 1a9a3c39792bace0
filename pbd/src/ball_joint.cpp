// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/ball_joint.h"

#include "tandem/pbd/corrections.h"

namespace tandem::pbd {

void BallJoint::check(const World& world, const Def& def) {
  if (def.a.valid()) detail::require_body(world, def.a, kName, "a");
  detail::require_body(world, def.b, kName, "b");
  detail::require(def.a != def.b, kName, "b", def.b.index, "must differ from a");
  detail::require_finite(def.anchor_a_l, kName, "anchor_a_l");
  detail::require_finite(def.anchor_b_l, kName, "anchor_b_l");
  detail::require(def.compliance >= 0.0 && std::isfinite(def.compliance), kName, "compliance",
                  def.compliance, "finite and >= 0");
  detail::require(def.damping >= 0.0 && std::isfinite(def.damping), kName, "damping", def.damping,
                  "finite and >= 0");
}

BallJoint::Arms BallJoint::arms(const SubstepContext& ctx, SolverBody& ground) const {
  Arms arms;
  arms.a = def_.a.valid() ? &ctx.bodies[def_.a.index] : &ground;
  arms.b = &ctx.bodies[def_.b.index];
  arms.r_a = arms.a->q * def_.anchor_a_l;
  arms.r_b = arms.b->q * def_.anchor_b_l;
  arms.c = (arms.b->x + arms.r_b) - (arms.a->x + arms.r_a);
  return arms;
}

void BallJoint::begin_substep(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  if (!arm.a->total && !arm.b->total) gap_ *= kGapDecay;
  c_start_ = arm.c;
  r_a_ = arm.r_a;
  r_b_ = arm.r_b;
  const double load = lambda_.norm();
  blend_a_ = arm_blend(*arm.a, load, arm.r_a);
  blend_b_ = arm_blend(*arm.b, load, arm.r_b);
  lambda_.setZero();
}

double BallJoint::project(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  const Vec3 r_a = r_a_ + blend_a_ * (arm.r_a - r_a_);
  const Vec3 r_b = r_b_ + blend_b_ * (arm.r_b - r_b_);
  const Mat3 k = point_inverse_mass(*arm.a, *arm.b, r_a, r_b);
  if (k.diagonal().minCoeff() <= 0.0) return 0.0;  // neither end can move
  const Vec3 dlambda =
      point_multiplier(arm.c - gap_, lambda_, k,
                       RowSoftness::of(def_.compliance, def_.damping, ctx.h), arm.c - c_start_);
  lambda_ += dlambda;
  force_ = lambda_ / (ctx.h * ctx.h);
  apply_pair(*arm.a, *arm.b, dlambda, r_a, r_b);
  return (k * dlambda).norm();
}

void BallJoint::want_substeps(const SubstepContext& ctx, std::span<double> wanted) const {
  want_for_turn(ctx, def_.a, def_.b, wanted);
}

void BallJoint::begin_total(const SubstepContext& ctx) {
  SolverBody ground;
  bound_ = arms(ctx, ground).c - gap_;
  total_.setZero();
}

void BallJoint::project_total(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  const Mat3 k = point_inverse_mass(*arm.a, *arm.b, arm.r_a, arm.r_b);
  if (k.diagonal().minCoeff() <= 0.0 && def_.compliance == 0.0) return;  // both ends are owned
  const Vec3 dlambda = point_multiplier(arm.c - bound_, total_, k,
                                        RowSoftness::of(def_.compliance, 0.0, ctx.h), Vec3::Zero());
  total_ += dlambda;
  apply_pair(*arm.a, *arm.b, dlambda, arm.r_a, arm.r_b);
}

void BallJoint::end_total(const SubstepContext& ctx) {
  if (def_.compliance > 0.0) return;  // a soft row keeps no debt: its stretch is a force
  SolverBody ground;
  gap_ = arms(ctx, ground).c - bound_;
}

void BallJoint::end_step(const SubstepContext& ctx) {
  SolverBody ground;
  residual_ = def_.compliance > 0.0 ? 0.0 : arms(ctx, ground).c.norm();
  // What a spoiled step leaves behind must not spoil the next one.
  if (!lambda_.allFinite()) lambda_.setZero();
  if (!gap_.allFinite()) gap_.setZero();
}

void BallJoint::save(ByteWriter& out) const {
  for (const BodyId id : {def_.a, def_.b}) {
    out.u32(id.index);
    out.u32(id.generation);
  }
  out.vec3(def_.anchor_a_l);
  out.vec3(def_.anchor_b_l);
  out.f64(def_.compliance);
  out.f64(def_.damping);
  out.vec3(lambda_);
  out.vec3(gap_);
  out.vec3(force_);
  out.f64(residual_);
}

void BallJoint::load(ByteReader& in) {
  for (BodyId* id : {&def_.a, &def_.b}) {
    id->index = in.u32();
    id->generation = in.u32();
  }
  def_.anchor_a_l = in.vec3();
  def_.anchor_b_l = in.vec3();
  def_.compliance = in.f64();
  def_.damping = in.f64();
  lambda_ = in.vec3();
  gap_ = in.vec3();
  force_ = in.vec3();
  residual_ = in.f64();
}

BallJoint::Def ball_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w) {
  detail::require_body(world, b, BallJoint::kName, "b");
  if (a.valid()) detail::require_body(world, a, BallJoint::kName, "a");
  return {.a = a,
          .b = b,
          .anchor_a_l = a.valid() ? world.pose(a).to_local(anchor_w) : anchor_w,
          .anchor_b_l = world.pose(b).to_local(anchor_w)};
}

}  // namespace tandem::pbd
