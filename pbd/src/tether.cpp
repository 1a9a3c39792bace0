// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/tether.h"

#include "byte_fields.h"
#include "tandem/pbd/corrections.h"

namespace tandem::pbd {
namespace {

/// Lists fields for saving or loading.
void tether_fields(auto io, auto& def, auto& force) {
  io(def.body, def.anchor_l, def.anchor_w, def.anchor_velocity, def.stiffness, def.damping,
     def.max_force, force);
}

}  // namespace

void Tether::check(const World& world, const Def& def) {
  detail::require_body(world, def.body, kName, "body");
  detail::require_finite(def.anchor_l, kName, "anchor_l");
  detail::require_finite(def.anchor_w, kName, "anchor_w");
  detail::require_finite(def.anchor_velocity, kName, "anchor_velocity");
  detail::require(def.stiffness >= kMinStiffness && def.stiffness <= kMaxStiffness, kName,
                  "stiffness", def.stiffness, "from 1e-9 to 1e15 N/m");
  detail::require(def.damping >= 0.0 && def.damping <= kMaxStiffness, kName, "damping", def.damping,
                  "from 0 to 1e15 N s/m");
  detail::require(def.max_force > 0.0, kName, "max_force", def.max_force, "> 0");
}

void Tether::begin_substep(const SubstepContext& ctx) {
  const SolverBody& body = ctx.bodies[def_.body.index];
  r_ = rotate(body.q, def_.anchor_l);
  c_start_ = body.x + r_ - def_.anchor_w;
  // The anchor moves in each substep, so that its motion is uniform in a step of any length and a
  // tether without updates coasts.
  def_.anchor_w += ctx.h * def_.anchor_velocity;
  lambda_.setZero();
}

double Tether::project(const SubstepContext& ctx) {
  SolverBody& body = ctx.bodies[def_.body.index];
  SolverBody ground;
  const Vec3 c = body.x + rotate(body.q, def_.anchor_l) - def_.anchor_w;
  const Mat3 k = point_inverse_mass(ground, body, Vec3::Zero(), r_);
  const Vec3 dlambda = point_multiplier(
      c, lambda_, k, RowSoftness::of(1.0 / def_.stiffness, def_.damping, ctx.h), c - c_start_);
  const Vec3 before = lambda_;
  lambda_ += dlambda;
  const double limit = def_.max_force * ctx.h * ctx.h;
  const double norm = lambda_.norm();
  if (norm > limit) lambda_ *= limit / norm;
  force_ = lambda_ / (ctx.h * ctx.h);
  const Vec3 p = lambda_ - before;
  apply_correction(body, p, r_.cross(p));
  return (k * p).norm();
}

void Tether::save(ByteWriter& out) const { tether_fields(FieldWriter(out), def_, force_); }

void Tether::load(ByteReader& in) {
  tether_fields(FieldReader(in), def_, force_);
  if (!(def_.stiffness >= kMinStiffness && def_.stiffness <= kMaxStiffness)) in.fail();
}

}  // namespace tandem::pbd
