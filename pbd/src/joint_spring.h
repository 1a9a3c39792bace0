// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_record.h"

/// Springs given by frequency and damping ratio.
namespace tandem::pbd {

class World;

/// Sets JointRecord::spring_mass of coordinates with such a spring: the mass (kg) or inertia (kg
/// m^2) that moves with the coordinate while the rigid locks hold, at the current poses, and its
/// armature; for a door, the inertia about its hinge. 0 if neither body moves.
void weigh_springs(JointRecord& record, const World& world);

/// Replaces the spring in `law` by one of given frequency. A single mass on it passes through
/// points of the closed form from substep to substep, at any substep length:
///
///   c_n+1 - P c_n + Q c_n-1 = 0,  P = 2 exp(-zeta w h) cos(w h sqrt(1 - zeta^2)),
///                                 Q = exp(-2 zeta w h).
///
/// This is the one law of the average acceleration method that does so (a spring at the mean of
/// three points, a damper between the outer ones). Its stiffness and damping are never below 0, so
/// that a body with any number of springs and loads stays bounded. Beyond the resolution of a
/// substep the spring in `law` is kept, which brakes.
/// @param mass   from weigh_springs()
/// @param c      coordinate at the start of the substep, m or rad; `rate` is its derivative
void tune_spring(ForceLaw& law, const JointSpring& spring, double mass, double c, double rate,
                 double h);

/// Target turn of a drive's springs, about each axis by itself. With different k_i, torques k_i
/// phi_i are not conservative: an undamped box came to 8.9 times its energy. Torques of the energy
/// sum k_i phi_i^2 / 2 are: J^-T k phi, with J the Jacobian of phi.
/// @param to_rest  rad, rotation vector phi from b to rest, in frame a
/// @param mass     kg m^2, per axis: proportional to the k_i; 0 if they are equal
/// @return         rad, in frame a, to be used with the same k_i
Vec3 spring_turn(const Vec3& to_rest, const Vec3& mass);

}  // namespace tandem::pbd
