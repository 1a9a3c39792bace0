// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
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
  float carried = 0.0f;       ///< N s, sum of what the substep began with
  float approach = 0.0f;      ///< m/s, fastest approach of a point before the substep, >= 0
  std::uint8_t count = 0;
  bool a_moves = false;      ///< a is not immovable
  bool sunk : 1 = false;     ///< some point overlaps
  bool bounces : 1 = false;  ///< some point does
  bool a_below : 1 = false;  ///< a is nearer to what cannot move: it carries b
  bool b_below : 1 = false;
  double friction = 0.0;  ///< Coulomb
  Vec3 normal = Vec3::UnitX();
  Vec3 t1 = Vec3::UnitY();
  Vec3 arm_a = Vec3::Zero();  ///< m, world, centre of mass to centre of pressure
  Vec3 arm_b = Vec3::Zero();
  Four impulse = Four::Zero();  ///< N s, normal, >= 0, of both passes
  /// m/s: > 0, the velocity at which the gap closes within the substep; < 0, minus the velocity at
  /// which the overlap is pushed open.
  Four bias = Four::Zero();
  std::array<double, 2> slide{};  ///< N s, both passes
  // Responses to forces (1/kg), couples (1/(kg m^2)) and between both (1/(kg m)).
  double press_n = 0.0;            ///< of V_n to F_n
  std::array<double, 3> grip{};    ///< of V_1, V_2 to F_1, F_2; symmetric: 11, 12, 22
  std::array<double, 2> slip_n{};  ///< of V_1, V_2 to F_n

  // A row of one point needs no more than what is above, half of the cache lines.
  Four bounce = Four::Zero();  ///< m/s, >= 0: normal velocity after an impact
  /// Combination of the four impulses that changes no motion, times the root of its compliance.
  Four idle = Four::Zero();
  Four s = Four::Zero();  ///< m, along t2 from the centre of pressure
  Four r = Four::Zero();  ///< m, against t1
  /// Of V_n, W_1, W_2 to F_n, T_1, T_2, beside press_n; symmetric: n1, n2, 11, 12, 22
  std::array<double, 5> press_w{};
  /// Of V_1, V_2, W_n to F_n, T_1, T_2, beside slip_n: 11, 12, 21, 22, nn, n1, n2
  std::array<double, 7> slip_w{};
  /// Of V_1, V_2, W_n to F_1, F_2, T_n, beside grip; symmetric: 1n, 2n, nn
  std::array<double, 3> grip_w{};
  double twist = 0.0;  ///< N m s, both passes

  Vec3 t2() const { return normal.cross(t1); }
  std::uint32_t movable() const { return a_moves ? a : b; }
  bool rubs() const { return friction > 0.0; }
  /// A point resists no twist.
  bool twists() const { return count > 1 && grip_w[2] > 0.0; }
  bool loaded() const { return (impulse > 0.0).any(); }
  /// Of V_1, V_2, W_n (rows) to F_n, T_1, T_2.
  Mat3 slip() const {
    Mat3 m;
    m << slip_n[0], slip_w[0], slip_w[1], slip_n[1], slip_w[2], slip_w[3], slip_w[4], slip_w[5],
        slip_w[6];
    return m;
  }
};
static_assert(sizeof(ContactRow) == 512, "a row should fill its cache lines");
static_assert(offsetof(ContactRow, bounce) == 256, "a row of one point should stay in its half");

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
/// @param fresh  friction starts anew in this substep
double solve_row(ContactRow& row, ContactPass pass, bool fresh, std::span<SolverBody> bodies);

/// Open overlaps through v_push and w_push, which move poses and are forgotten after the substep.
/// What lies below counts as no lighter than what lies on it, as if the ground helped: pushed into
/// what it stands on, a light body would never get a heavy one off. Boxes of 300 times the mass
/// that fall on a pyramid end 1 mm deep instead of 0.3 m.
/// @param pushed  by body: it has such velocities already
void push_row(const ContactRow& row, std::span<SolverBody> bodies, std::span<std::uint8_t> pushed);

/// Gap of point i as the bodies stand, m.
double gap_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b, int i);

/// Lever arms (m, world) from both centres of mass to a common point of contact, so that a pair of
/// opposite impulses keeps angular momentum.
struct ContactArms {
  std::array<Vec3, 4> a;
  std::array<Vec3, 4> b;
};
/// @param gaps  set to those of the points, see gap_of(), where it is not null
ContactArms arms_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b,
                    std::array<double, 4>* gaps = nullptr);

}  // namespace tandem::pbd
