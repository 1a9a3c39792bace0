// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "joint_record.h"

/// Springs that are told by frequency and damping ratio.
namespace tandem::pbd {

class World;

/// Of each coordinate that has such a spring, into JointRecord::spring_mass: the mass (kg) or
/// inertia (kg m^2) that moves with it while the joint's rigid locks hold, as the bodies stand: of
/// a door on a hinge the inertia about the hinge. 0 where neither body moves.
void weigh_springs(JointRecord& record, const World& world);

/// The law of a coordinate with such a spring, in place of the spring that `law` has. A mass that
/// moves on it alone goes, from substep to substep, through points of the closed form, whatever the
/// length of the substep:
///
///   c_n+1 - P c_n + Q c_n-1 = 0,  P = 2 exp(-zeta w h) cos(w h sqrt(1 - zeta^2)),
///                                 Q = exp(-2 zeta w h).
///
/// The one law of the average acceleration method that does so is taken (a spring at the mean of
/// three points, a damper between the outer ones): its stiffness and damping are never below 0, so
/// that however many springs hold a body, and whatever else it carries, it stays bounded. Beyond
/// what a substep resolves it is the spring that `law` has, which brakes.
/// @param mass   as of weigh_springs()
/// @param c      coordinate at the start of the substep, m or rad, and how fast it changes
void tune_spring(ForceLaw& law, const JointSpring& spring, double mass, double c, double rate,
                 double h);

/// Where the springs of a drive pull to, about each axis by itself. Torques of k_i phi_i do work on
/// a way that leads back to where it began, wherever the k_i differ: an undamped box came to 8.9
/// times its energy. Those of the energy sum k_i phi_i^2 / 2 do not: J^-T k phi, J the Jacobian of
/// phi.
/// @param to_rest  rad, rotation vector phi from where b is to rest, in frame a
/// @param mass     kg m^2, of each axis: what the k_i are in proportion to; 0 where they are equal
/// @return         rad, in frame a, with the same k_i
Vec3 spring_turn(const Vec3& to_rest, const Vec3& mass);

}  // namespace tandem::pbd
