// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/math.h"

/// The maths of a correction, once: every kind of constraint composes these.
/// Legend: C constraint violation [m], alpha compliance [m/N], at = alpha / h^2, lambda multiplier
/// [N s^2] (force = lambda / h^2), w generalised inverse mass [1/kg], r lever arm from the centre
/// of mass [m, world].
namespace tandem::pbd {

/// Bodies closer than this (m) have no direction between them.
inline constexpr double kMinLength = 1e-12;

/// Move `body` as an impulse p (N s^2) with moment m (N m s^2) does within one substep.
/// Source: [mueller2020] Sec. 3.3.1. Differs: the rotation is the exact exponential.
inline void apply_correction(SolverBody& body, const Vec3& p, const Vec3& m) {
  if (body.inv_mass == 0.0) return;
  const Vec3 dx = body.inv_mass * p;
  const Vec3 dtheta = body.inv_inertia_w * m;
  body.x += dx;
  body.dx += dx;
  body.q = rotated(body.q, dtheta);
  body.dtheta += dtheta;
}

/// Impulse p on body b at lever arm r_b, and -p on body a at r_a.
inline void apply_pair(SolverBody& a, SolverBody& b, const Vec3& p, const Vec3& r_a,
                       const Vec3& r_b) {
  apply_correction(a, -p, -r_a.cross(p));
  apply_correction(b, p, r_b.cross(p));
}

/// The same on velocities; p in N s.
inline void apply_velocity_pair(SolverBody& a, SolverBody& b, const Vec3& p, const Vec3& r_a,
                                const Vec3& r_b) {
  a.v -= a.inv_mass * p;
  a.w -= a.inv_inertia_w * r_a.cross(p);
  b.v += b.inv_mass * p;
  b.w += b.inv_inertia_w * r_b.cross(p);
}

/// w = 1/m + (r x n)^T I^-1 (r x n). Source: [mueller2020] Sec. 3.3.1.
inline double inverse_mass(const SolverBody& body, const Vec3& r, const Vec3& n) {
  const Vec3 rn = r.cross(n);
  return body.inv_mass + rn.dot(body.inv_inertia_w * rn);
}

/// K = (1/m_a + 1/m_b) E + [r_a]^T I_a^-1 [r_a] + [r_b]^T I_b^-1 [r_b]: how far the gap between two
/// points opens for each unit of impulse between them.
inline Mat3 point_inverse_mass(const SolverBody& a, const SolverBody& b, const Vec3& r_a,
                               const Vec3& r_b) {
  const Mat3 sa = skew(r_a);
  const Mat3 sb = skew(r_b);
  Mat3 k = sa.transpose() * a.inv_inertia_w * sa + sb.transpose() * b.inv_inertia_w * sb;
  k.diagonal().array() += a.inv_mass + b.inv_mass;
  return k;
}

/// Stiffness-independent form of a spring-damper's substep.
struct RowSoftness {
  double at = 0.0;     ///< alpha / h^2, 1/kg
  double gamma = 0.0;  ///< damping / (stiffness h), 1

  /// @param compliance  m/N, >= 0     @param damping  N s/m, >= 0; without effect on a rigid row
  static RowSoftness of(double compliance, double damping, double h) {
    return {compliance / (h * h), compliance * damping / h};
  }
};

/// dlambda = (-C - at lambda - gamma slip) / ((1 + gamma) w + at).
/// Source: [macklin2016] Eqs. 18 (undamped) and 26 (damped). slip = change of C in this substep.
inline double row_multiplier(double c, double lambda, double w, const RowSoftness& softness,
                             double slip) {
  const double denominator = (1.0 + softness.gamma) * w + softness.at;
  if (denominator <= 0.0) return 0.0;
  return (-c - softness.at * lambda - softness.gamma * slip) / denominator;
}

/// The same for the three rows of a point at once, solved as a block.
inline Vec3 point_multiplier(const Vec3& c, const Vec3& lambda, const Mat3& k,
                             const RowSoftness& softness, const Vec3& slip) {
  Mat3 block = (1.0 + softness.gamma) * k;
  block.diagonal().array() += softness.at;
  return block.inverse() * (-c - softness.at * lambda - softness.gamma * slip);
}

/// Which lever arm a rigid row turns bodies by, as a blend from the substep's start (0) to the
/// predicted pose (1). The start keeps energy but is stable only while the joint's own force turns
/// the body slowly, (rate h)^2 = |lambda| |r| / I well below 4; the predicted pose damps and is
/// stable beyond. Blends over from 1/4 to 1.
/// @param lambda  N s^2, size of the multiplier in the last substep     @param r  m, lever arm
inline double arm_blend(const SolverBody& body, double lambda, const Vec3& r) {
  const double length = r.norm();
  if (length < kMinLength) return 0.0;
  // Turning about r itself does not move the anchor.
  const double across =
      body.inv_inertia_w.trace() - r.dot(body.inv_inertia_w * r) / (length * length);
  return std::clamp((lambda * length * across - 0.25) / 0.75, 0.0, 1.0);
}

/// Angular velocity (rad/s) that keeps the angular momentum of the predicted pose once corrections
/// have turned the body on, R = rotation by dtheta: w = R I^-1 R^T I w. Without it a fast top loses
/// its spin to the joint that holds it, since its inertia turns with it.
/// @pre w includes dtheta / h; `inv_inertia_w` is that of the predicted pose
inline Vec3 transported_spin(const SolverBody& body) {
  const Mat3& inv = body.inv_inertia_w;
  const double mean = inv.trace() / 3.0;
  const double spread = (inv - mean * Mat3::Identity()).squaredNorm();
  constexpr double kIsotropic = 1e-20;
  if (!(spread > kIsotropic * mean * mean) || body.dtheta.squaredNorm() == 0.0) return body.w;
  const Mat3 turn = exp_map(body.dtheta).toRotationMatrix();
  const Vec3 momentum = inv.inverse() * body.w;
  return turn * (inv * (turn.transpose() * momentum));
}

/// What agreement left of a row's violation is let into the real channel at this rate for each
/// substep once no target is about that could repair it without velocity: 1 mm fades at 12 mm/s.
inline constexpr double kGapDecay = 0.98;

/// Velocity (m/s) of the material point of `body` at lever arm r.
inline Vec3 point_velocity(const SolverBody& body, const Vec3& r) {
  return body.v + body.w.cross(r);
}

/// Displacement (m) of that point within this substep so far, before derive_velocities.
inline Vec3 point_displacement(const SolverBody& body, const Vec3& r, double h) {
  return h * point_velocity(body, r) + body.dx + body.dtheta.cross(r);
}

/// Ask for as many substeps of a step of ctx.h as keep two joined bodies from turning by more than
/// 0.05 rad against each other in one: swinging chains then keep their energy to about 1 %.
inline void want_for_turn(const SubstepContext& ctx, BodyId a, BodyId b, std::span<double> wanted) {
  constexpr double kTurn = 0.05;  // rad
  const Vec3 w_a = a.valid() ? ctx.bodies[a.index].w : Vec3(Vec3::Zero());
  const double count = ctx.h * (ctx.bodies[b.index].w - w_a).norm() / kTurn;
  wanted[b.index] = std::max(wanted[b.index], count);
}

}  // namespace tandem::pbd
