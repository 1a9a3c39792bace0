// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/distance_joint.h"

#include "byte_fields.h"
#include "joint_rows.h"

namespace tandem::pbd {
namespace {

/// Lists fields for saving or loading.
void distance_fields(auto& io, auto& def) {
  io(def.a, def.b, def.anchor_a_l, def.anchor_b_l, def.rest_length, def.compliance, def.damping,
     def.elastic, def.min_length, def.max_length, def.range_compliance, def.range_damping,
     def.break_force, def.enabled);
}

}  // namespace

void DistanceJoint::check(const World& world, const Def& def) {
  if (def.a.valid()) detail::require_body(world, def.a, kName, "a");
  detail::require_body(world, def.b, kName, "b");
  detail::require(def.a != def.b, kName, "b", def.b.index, "another body than a");
  detail::require_finite(def.anchor_a_l, kName, "anchor_a_l");
  detail::require_finite(def.anchor_b_l, kName, "anchor_b_l");
  detail::require(def.rest_length >= 0.0 && std::isfinite(def.rest_length), kName, "rest_length",
                  def.rest_length, "finite and >= 0");
  detail::require(
      def.compliance == 0.0 || (def.compliance >= kMinCompliance && std::isfinite(def.compliance)),
      kName, "compliance", def.compliance, "0, or finite and at least 1e-100");
  detail::require(def.damping >= 0.0 && std::isfinite(def.damping), kName, "damping", def.damping,
                  "finite and >= 0");
  detail::require(def.min_length >= 0.0 && std::isfinite(def.min_length), kName, "min_length",
                  def.min_length, "finite and >= 0");
  detail::require(def.max_length >= def.min_length, kName, "max_length", def.max_length,
                  ">= min_length");
  detail::require(
      def.range_compliance == 0.0 ||
          (def.range_compliance >= kMinCompliance && std::isfinite(def.range_compliance)),
      kName, "range_compliance", def.range_compliance, "0, or finite and at least 1e-100");
  detail::require(def.range_damping >= 0.0 && std::isfinite(def.range_damping), kName,
                  "range_damping", def.range_damping, "finite and >= 0");
  detail::require(def.break_force >= 0.0 && std::isfinite(def.break_force), kName, "break_force",
                  def.break_force, "finite and >= 0");
  if (!def.elastic) return;
  detail::require(def.rest_length >= def.min_length && def.rest_length <= def.max_length, kName,
                  "rest_length", def.rest_length, "from min_length to max_length");
}

JointAxis DistanceJoint::axis() const {
  const bool rod = def_.elastic && def_.compliance == 0.0;
  const bool ranged = def_.min_length > 0.0 || def_.max_length < kUnlimited;
  JointAxis axis;
  if (rod || (def_.elastic && !ranged)) {
    axis.freedom = Freedom::Locked;
    axis.compliance = def_.compliance;
    axis.damping = def_.damping;
    return axis;
  }
  if (ranged) {
    axis.freedom = Freedom::Limited;
    axis.lower = def_.min_length - def_.rest_length;
    axis.upper = def_.max_length - def_.rest_length;
    axis.compliance = def_.range_compliance;
    axis.damping = def_.range_damping;
  }
  if (def_.elastic) axis.spring = {.stiffness = 1.0 / def_.compliance, .damping = def_.damping};
  return axis;
}

DistanceJoint::Arms DistanceJoint::arms(const SubstepContext& ctx, SolverBody& ground) const {
  Arms arms;
  arms.a = def_.a.valid() ? &ctx.bodies[def_.a.index] : &ground;
  arms.b = &ctx.bodies[def_.b.index];
  arms.r_a = rotate(arms.a->q, def_.anchor_a_l);
  arms.r_b = rotate(arms.b->q, def_.anchor_b_l);
  const Vec3 d = (arms.b->x + arms.r_b) - (arms.a->x + arms.r_a);
  arms.length = d.norm();
  // Coinciding points have no direction: the row waits until they part.
  arms.n = arms.length > kMinLength ? Vec3(d / arms.length) : Vec3(Vec3::Zero());
  return arms;
}

void DistanceJoint::forgive(const SubstepContext& ctx) {
  SolverBody ground;
  displacement_residual_ = residual_of(axis(), arms(ctx, ground).length - def_.rest_length);
}

bool DistanceJoint::find_gap(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  if (arm.a->agreed || arm.b->agreed) {  // as in joints
    gap_ = {};
    return false;
  }
  const double violated = residual_of(axis(), arm.length - def_.rest_length);
  if (std::abs(violated) > residual_ + JointGap::kTolerance) gap_.open(std::abs(violated));
  if (!gap_.is_open()) return false;
  displacement_residual_ = violated;
  bool marked = false;
  for (SolverBody* body : {arm.a, arm.b}) {
    if (body->is_solved()) marked = body->shared = true;
  }
  return marked;
}

void DistanceJoint::begin_substep(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  c_start_ = arm.length - def_.rest_length;
  const bool left = ctx.substep > 0 && !n_.isZero(0.0) && (arm.a->pushed || arm.b->pushed);
  displacement_residual_ = residual_at_start(axis(), c_start_, displacement_residual_, left,
                                             arm.a->shared || arm.b->shared, ctx.h);
  r_a_ = arm.r_a;
  r_b_ = arm.r_b;
  n_ = arm.n;
  lambda_ = 0.0;
  force_ = 0.0;
  broken_ = false;
}

double DistanceJoint::project(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  const double c = arm.length - def_.rest_length;
  // Points that have swung past each other within the substep need a new direction.
  if (n_.dot(arm.n) < 0.5) n_ = arm.n;
  if (n_.isZero(0.0)) return 0.0;
  const double w = inverse_mass(*arm.a, r_a_, n_) + inverse_mass(*arm.b, r_b_, n_);
  const double dlambda =
      force_law(axis(), c_start_, displacement_residual_, ctx.h).multiplier(c, lambda_, w);
  lambda_ += dlambda;
  force_ = lambda_ / (ctx.h * ctx.h);
  apply_pair(*arm.a, *arm.b, dlambda * n_, r_a_, r_b_);
  return std::abs(dlambda) * w;
}

void DistanceJoint::finish_velocity(const SubstepContext& /*ctx*/) {
  if (!(def_.break_force > 0.0 && std::abs(force_) > def_.break_force)) return;
  broken_ = broke_ = true;
  def_.enabled = false;
}

void DistanceJoint::begin_displacement(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  const bool agreed = arm.a->agreed || arm.b->agreed;
  const double reach = agreed ? HUGE_VAL : ctx.h * kClosingSpeed;
  const double now = std::clamp(displacement_residual_, -reach, reach);
  bound_ = arm.length - def_.rest_length - now;
  displacement_residual_ -= now;
  lambda_ = 0.0;
}

double DistanceJoint::project_displacement(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  if (arm.n.isZero(0.0)) return 0.0;
  const double c = arm.length - def_.rest_length;
  const double w = inverse_mass(*arm.a, arm.r_a, arm.n) + inverse_mass(*arm.b, arm.r_b, arm.n);
  const double dlambda = displacement_law(axis(), bound_, ctx.h).multiplier(c, lambda_, w);
  lambda_ += dlambda;
  apply_pair(*arm.a, *arm.b, dlambda * arm.n, arm.r_a, arm.r_b);
  return std::abs(dlambda) * w;
}

void DistanceJoint::end_displacement(const SubstepContext& ctx) {
  SolverBody ground;
  displacement_residual_ =
      gap_left(axis(), arms(ctx, ground).length - def_.rest_length, bound_, displacement_residual_);
}

void DistanceJoint::end_step(const SubstepContext& ctx) {
  SolverBody ground;
  const Arms arm = arms(ctx, ground);
  const double c = arm.length - def_.rest_length;
  residual_ = violation(axis(), c);
  if ((arm.a->is_pushed() || arm.b->is_pushed()) && !n_.isZero(0.0)) {
    displacement_residual_ = residual_of(axis(), c);
  }
  if (!def_.enabled) {
    if (!broke_) force_ = 0.0;
    broke_ = false;
    displacement_residual_ = residual_ = 0.0;
  }
  // A non-finite step must not spoil the next one.
  for (double* value : {&displacement_residual_, &force_, &residual_}) {
    if (!std::isfinite(*value)) *value = 0.0;
  }
  if (!n_.allFinite()) n_.setZero();
  gap_.settle(std::abs(displacement_residual_));
}

void DistanceJoint::save(ByteWriter& out) const {
  FieldWriter io(out);
  distance_fields(io, def_);
  io(broken_, n_, displacement_residual_, gap_.least, gap_.stalled, force_, residual_);
}

void DistanceJoint::load(ByteReader& in) {
  FieldReader io(in);
  distance_fields(io, def_);
  io(broken_, n_, displacement_residual_, gap_.least, gap_.stalled, force_, residual_);
  if (!n_.allFinite() || !std::isfinite(displacement_residual_) || !std::isfinite(force_) ||
      !std::isfinite(residual_) || !std::isfinite(gap_.least) || gap_.least < 0.0) {
    in.fail();
  }
}

}  // namespace tandem::pbd
