// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>

#include "tandem/pbd/body.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {

/// The product at unit length; a first-order correction if q is a unit quaternion up to rounding.
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

/// Same as rotated(), with turned_by().
inline Quat rotated_about(const Quat& q, const Vec3& r) { return turned_by(exp_map(r), q); }

/// Inverse inertia in the world at the orientation q, on the axes that are not locked: torque about
/// locked axes is balanced.
void inverse_inertia_w(const Quat& q, const BodyProps& props, Mat3& result);

/// Sets the inverse inertia for the body's orientation.
void refresh_inertia(SolverBody& body, const BodyProps& props);

/// Measure of the error of rows on a body that has turned by `turn` (rad) since they were made: it
/// grows with the ratio of its moments and is 0 if these are equal.
double staleness(double turn, const Vec3& moments);
/// Staleness from which on rows are made again.
inline constexpr double kStale = 0.02;  // rad

/// Applies forces and damping for one substep of a dynamic body: v and w become the velocities of
/// its motion. Torque-free rotation of a body whose rows project poses is done here, pose included,
/// as these rows start from it; for other bodies advance_pose() does it.
/// @param wrench  null if none acts
void integrate_velocity(SolverBody& body, const BodyProps& props, const Wrench* wrench,
                        const Vec3& gravity, double h);

/// Applies the part of v and w to the pose that it does not show yet. With torque-free rotation, w
/// becomes the spin at the end and the inertia that of the new pose: rows have changed w with the
/// old inertia, which adds no energy, and free rotation adds none.
void advance_pose(SolverBody& body, const BodyProps& props, double h);

/// For a body whose rows project poses: applies v and w alone. Push velocities are left out, as
/// joints would turn them into velocity in each alternation.
void follow_velocity(SolverBody& body, double h);

/// Velocities take over what rows that project poses have moved. Corrections change the angular
/// momentum, not the spin: otherwise a fast top loses spin to the joint that holds it, as its
/// inertia turns with it.
/// @pre `inv_inertia_w` is that of the predicted pose
void absorb_corrections(SolverBody& body, const BodyProps& props, double h);

/// Clears the components of locked axes.
void zero_locked_axes(const std::array<bool, 3>& locked, Vec3& vector);

/// Removes velocity along and about locked axes.
void enforce_locks(SolverBody& body, const AxisLocks& locks);

/// Resets locked translation to the start of the step: rows treat it as free.
void restore_locked(SolverBody& body, const AxisLocks& locks, const Vec3& start);

}  // namespace tandem::pbd
