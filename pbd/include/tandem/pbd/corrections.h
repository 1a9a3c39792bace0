// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/math.h"

/// The maths of a correction, shared by all kinds of constraints.
/// Legend: C constraint violation [m], alpha compliance [m/N], at = alpha / h^2, lambda multiplier
/// [N s^2] (force = lambda / h^2), w generalised inverse mass [1/kg], r lever arm from the centre
/// of mass [m, world].
namespace tandem::pbd {

/// m: the direction between points closer than this is undefined.
inline constexpr double kMinLength = 1e-12;

/// Moves `body` as an impulse p (N s^2) with moment m (N m s^2) does within one substep.
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

/// Applies impulse p to body b at lever arm r_b, and -p to body a at r_a.
inline void apply_pair(SolverBody& a, SolverBody& b, const Vec3& p, const Vec3& r_a,
                       const Vec3& r_b) {
  apply_correction(a, -p, -r_a.cross(p));
  apply_correction(b, p, r_b.cross(p));
}

/// w = 1/m + (r x n)^T I^-1 (r x n). Source: [mueller2020] Sec. 3.3.1.
inline double inverse_mass(const SolverBody& body, const Vec3& r, const Vec3& n) {
  const Vec3 rn = r.cross(n);
  return body.inv_mass + rn.dot(body.inv_inertia_w * rn);
}

/// K = (1/m_a + 1/m_b) E + [r_a]^T I_a^-1 [r_a] + [r_b]^T I_b^-1 [r_b]: opening of the gap between
/// two points per unit of impulse between them.
inline Mat3 point_inverse_mass(const SolverBody& a, const SolverBody& b, const Vec3& r_a,
                               const Vec3& r_b) {
  const Mat3 sa = skew(r_a);
  const Mat3 sb = skew(r_b);
  Mat3 k = sa.transpose() * a.inv_inertia_w * sa + sb.transpose() * b.inv_inertia_w * sb;
  k.diagonal().array() += a.inv_mass + b.inv_mass;
  return k;
}

/// Stiffness-independent form of a spring-damper's substep.
struct TANDEM_API RowSoftness {
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

/// Multiplier of the three rows of a point, solved as a block.
inline Vec3 point_multiplier(const Vec3& c, const Vec3& lambda, const Mat3& k,
                             const RowSoftness& softness, const Vec3& slip) {
  Mat3 block = (1.0 + softness.gamma) * k;
  block.diagonal().array() += softness.at;
  return block.inverse() * (-c - softness.at * lambda - softness.gamma * slip);
}

/// 1/s: rate at which residual violation, left by agreement or later rows, closes. It gives
/// velocity: 1 mm at 20 mm/s. At 60/s limbs that fall on their end do not always come to rest.
inline constexpr double kResidualRate = 20.0;
/// The part of the residual that is left after a substep of length h (s).
inline double residual_decay(double h) { return 1.0 / (1.0 + kResidualRate * h); }

}  // namespace tandem::pbd
