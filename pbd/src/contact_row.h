// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

#include "contact_lcp.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

/// A contact as the sweeps see it: a frame and a mobility of one step, multipliers of one substep.
/// Both bodies are seen from one point, the centre of pressure, in the axes (normal, t1, t2): V is
/// its relative velocity and W the relative spin. Point i approaches with  V_n + s_i W_1 + r_i W_2,
/// friction sees V_1, V_2 and W_n; all impulses add up to one force and one couple there.
struct alignas(64) ContactRow {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t contact = 0;  ///< index into the block's contacts
  std::uint32_t movable = 0;  ///< a, or b where a cannot move
  std::uint8_t count = 0;
  bool rubs = false;            ///< has friction
  bool sunk = false;            ///< some point overlaps
  double friction = 0.0;        ///< Coulomb
  Four impulse = Four::Zero();  ///< N s, normal, >= 0, of both passes
  /// m/s: > 0, the velocity at which the gap closes within the substep; < 0, minus the velocity at
  /// which the overlap is pushed open.
  Four bias = Four::Zero();
  Four bounce = Four::Zero();  ///< m/s, >= 0: normal velocity after an impact
  double approach = 0.0;       ///< m/s, fastest approach of a point before the substep, >= 0
  double carried = 0.0;        ///< N s, sum of what the substep began with
  /// Combination of the four impulses that changes no motion, times the root of its compliance.
  Four idle = Four::Zero();
  Vec3 normal = Vec3::UnitX();
  Vec3 t1 = Vec3::UnitY();
  Vec3 arm_a = Vec3::Zero();  ///< m, world, centre of mass to centre of pressure
  Vec3 arm_b = Vec3::Zero();
  Four s = Four::Zero();  ///< m, along t2 from the centre of pressure
  Four r = Four::Zero();  ///< m, against t1
  /// Response to forces (1/kg), couples (1/(kg m^2)) and between both (1/(kg m)):
  /// of V_n, W_1, W_2 to F_n, T_1, T_2; symmetric: nn, n1, n2, 11, 12, 22
  std::array<double, 6> press{};
  Mat3 slip = Mat3::Zero();                ///< of V_1, V_2, W_n (rows) to F_n, T_1, T_2
  double m11 = 0.0, m12 = 0.0, m22 = 0.0;  ///< of V_1 and V_2 to friction
  double mw = 0.0;                         ///< of W_n to the couple of friction
  std::array<double, 2> slide{};           ///< N s, both passes
  double twist = 0.0;                      ///< N m s, both passes

  Vec3 t2() const { return normal.cross(t1); }
  bool loaded() const { return (impulse > 0.0).any(); }
};

/// Force and couple at the centre of pressure on body b, their opposite on a: components along
/// (normal, t1, t2).
struct ContactWrench {
  Vec3 force = Vec3::Zero();   ///< N s
  Vec3 couple = Vec3::Zero();  ///< N m s
};

/// How gaps become velocities in a substep.
struct SubstepRule {
  double push_gain = 0.0;       ///< share of an overlap opened in a substep
  double push_speed = 0.0;      ///< m/s, at most
  double push_slop = 0.0;       ///< m, overlap that is left alone
  double warm_start_gap = 0.0;  ///< m, carried impulses of wider gaps are dropped
  double bounce_speed = 0.0;    ///< m/s, slower impacts do not bounce
  Vec3 gravity = Vec3::Zero();  ///< m/s^2
};

/// Which velocities a row asks for.
enum class ContactPass {
  Motion,    ///< the substep's: gaps may close but not overlap more
  Velocity,  ///< that of its end: none into the contact, bounces
};

/// Jacobians and mobilities for the poses of the step's start.
void prepare_row(const Contact& contact, std::span<const SolverBody> bodies,
                 const ContactOptions& options, ContactRow& row);

/// Gaps and velocities of the substep's start. Friction is carried from substep to substep, which
/// heaps need, but starts anew in each step: carried on, it never comes to rest.
void begin_row(const Contact& contact, const SubstepRule& rule, double h,
               std::span<const SolverBody> bodies, ContactRow& row);

/// Share of its impulses that a row hands on: an impact is no load, and replayed in the next
/// substep it would throw off again what has just landed. A load builds up over a few substeps
/// instead.
double share_to_carry(const ContactRow& row, double gravity, double h);

/// Change v and w of both bodies as the row's impulses do.
void warm_start_row(const ContactRow& row, std::span<SolverBody> bodies);

/// Solve a row's normals, then its friction. Returns the largest change of a normal velocity, m/s.
double solve_row(ContactRow& row, ContactPass pass, std::span<SolverBody> bodies);

/// Open overlaps through v_push and w_push, which move poses and are forgotten after the substep.
/// Returns whether there was anything to do.
bool push_row(const ContactRow& row, std::span<SolverBody> bodies);

/// Gap of point i as the bodies stand, m.
double gap_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b, int i);

/// Lever arms (m, world) from both centres of mass to a common point of contact, so that a pair of
/// opposite impulses keeps angular momentum.
struct ContactArms {
  std::array<Vec3, 4> a;
  std::array<Vec3, 4> b;
};
ContactArms arms_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b);

}  // namespace tandem::pbd
