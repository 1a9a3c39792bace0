// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>

#include "tandem/pbd/body.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {

/// The product, kept at unit length; without a root where q has that but for rounding.
inline Quat turned_by(const Quat& turn, const Quat& q) {
  Quat result = turn * q;
  const double excess = result.squaredNorm() - 1.0;
  if (std::abs(excess) < 1e-8) {
    result.coeffs() *= 1.0 - 0.5 * excess;  // the next term is below 1e-16
  } else {
    result.normalize();
  }
  return result;
}

/// As rotated().
inline Quat rotated_about(const Quat& q, const Vec3& r) { return turned_by(exp_map(r), q); }

/// Inverse inertia in the world at the orientation q: of the axes that are not locked, as if a
/// torque about the others were always met by an equal one.
void inverse_inertia_w(const Quat& q, const BodyProps& props, Mat3& result);

/// That of the body's orientation.
void refresh_inertia(SolverBody& body, const BodyProps& props);

/// What rows take for a blow where a body has turned by `turn` (rad) since they were made goes by
/// the ratio of its moments; 0 where these are equal.
double staleness(double turn, const Vec3& moments);
/// Of that, from where on rows are made anew.
inline constexpr double kStale = 0.02;  // rad

/// Forces and damping for one substep of a dynamic body: v and w become those with which it moves.
/// A body whose rows project poses and whose spin changes by itself turns freely here, pose and
/// all, since these rows start from there; any other one does in advance_pose().
/// @param wrench  null where none acts
void integrate_velocity(SolverBody& body, const BodyProps& props, const Wrench* wrench,
                        const Vec3& gravity, double h);

/// Bring the pose up to what v and w say of this substep and the pose does not show yet. Where the
/// spin changes by itself, w becomes that at its end and the inertia that of the new pose: rows
/// have changed w with the inertia of the old one, which adds no energy, and turning freely adds
/// none.
void advance_pose(SolverBody& body, const BodyProps& props, double h);

/// Of a body whose rows project poses: bring the pose up to v and w alone. What opens overlaps is
/// no motion: joints would make velocity of it, in each of their turns anew.
void follow_velocity(SolverBody& body, double h);

/// Velocities learn what rows that project poses have moved. Corrections change angular momentum,
/// not spin: without that a fast top loses its spin to the joint that holds it, since its inertia
/// turns with it.
/// @pre `inv_inertia_w` is that of the predicted pose
void absorb_corrections(SolverBody& body, const BodyProps& props, double h);

/// Take out the components of locked axes.
void zero_locked_axes(const std::array<bool, 3>& locked, Vec3& vector);

/// Take out the velocity along and about locked axes.
void enforce_locks(SolverBody& body, const AxisLocks& locks);

/// Rows know locked translation as free: put it back to where the step began.
void restore_locked(SolverBody& body, const AxisLocks& locks, const Vec3& start);

}  // namespace tandem::pbd
