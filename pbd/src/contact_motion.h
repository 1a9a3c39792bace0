// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a row sees of its two bodies, and what it does to them. Inline: it is most of a sweep.
#pragma once

#include "contact_row.h"

namespace tandem::pbd {

/// Force and couple at the centre of pressure on body b, their opposite on a: components along
/// (normal, t1, t2).
struct ContactWrench {
  Vec3 force = Vec3::Zero();   ///< N s
  Vec3 couple = Vec3::Zero();  ///< N m s
};

/// Relative motion of b against a at the centre of pressure, world.
struct RelativeMotion {
  Vec3 v;  ///< m/s
  Vec3 w;  ///< rad/s
};

[[gnu::always_inline]] inline Vec3 relative_velocity(const ContactRow& row, const SolverBody& a,
                                                     const SolverBody& b) {
  return b.v - a.v + b.w.cross(row.arm_b) - a.w.cross(row.arm_a);
}

[[gnu::always_inline]] inline RelativeMotion relative_motion(const ContactRow& row,
                                                             const SolverBody& a,
                                                             const SolverBody& b) {
  return {relative_velocity(row, a, b), b.w - a.w};
}

/// Change both bodies' `linear` and `angular` velocities by a force (N s) and a couple (N m s) at
/// the centre of pressure, world.
[[gnu::always_inline]] inline void apply_wrench(const ContactRow& row, const Vec3& force,
                                                const Vec3& couple, SolverBody& a, SolverBody& b,
                                                Vec3 SolverBody::*linear,
                                                Vec3 SolverBody::*angular) {
  if (a.inv_mass > 0.0) {
    a.*linear -= a.inv_mass * force;
    a.*angular -= a.inv_inertia_w * (row.arm_a.cross(force) + couple);
  }
  if (b.inv_mass > 0.0) {
    b.*linear += b.inv_mass * force;
    b.*angular += b.inv_inertia_w * (row.arm_b.cross(force) + couple);
  }
}

/// The same for a force alone.
[[gnu::always_inline]] inline void apply_force(const ContactRow& row, const Vec3& force,
                                               SolverBody& a, SolverBody& b,
                                               Vec3 SolverBody::*linear,
                                               Vec3 SolverBody::*angular) {
  if (a.inv_mass > 0.0) {
    a.*linear -= a.inv_mass * force;
    a.*angular -= a.inv_inertia_w * row.arm_a.cross(force);
  }
  if (b.inv_mass > 0.0) {
    b.*linear += b.inv_mass * force;
    b.*angular += b.inv_inertia_w * row.arm_b.cross(force);
  }
}

}  // namespace tandem::pbd
