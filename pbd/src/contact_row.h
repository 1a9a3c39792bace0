// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

#include "tandem/pbd/contact.h"

namespace tandem::pbd {

/// A contact as the sweeps see it: Jacobians of one step, multipliers of one substep. The velocity
/// of point i along the normal is  n . (v_b - v_a) + rn_b,i . w_b - rn_a,i . w_a.
struct alignas(64) ContactRow {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t contact = 0;  ///< index into the block's contacts
  std::uint32_t movable = 0;  ///< a, or b where a cannot move
  std::uint8_t count = 0;
  bool rubs = false;                ///< has friction
  bool sunk = false;                ///< some point overlaps
  double friction = 0.0;            ///< Coulomb
  std::array<double, 4> impulse{};  ///< N s, normal, >= 0, of both passes
  /// m/s: > 0, the velocity at which the gap closes within the substep; < 0, minus the velocity at
  /// which the overlap is pushed open.
  std::array<double, 4> bias{};
  std::array<double, 4> bounce{};  ///< m/s, >= 0: normal velocity after an impact
  double approach = 0.0;           ///< m/s, fastest approach of a point before the substep, >= 0
  /// Combination of the four impulses that changes no motion, times the root of its compliance.
  std::array<double, 4> idle{};
  Vec3 normal;
  std::array<Vec3, 4> rn_a;  ///< m, arm x normal
  std::array<Vec3, 4> rn_b;
  std::array<std::array<double, 4>, 4> mobility{};  ///< 1/kg, J M^-1 J^T, plus idle idle^T
  std::array<double, 4> mass{};  ///< kg, of each point alone; 0 where nothing can move

  // Friction, at the centre of pressure.
  std::array<Vec3, 2> tangent;
  std::array<Vec3, 2> rt_a;  ///< m, arm x tangent
  std::array<Vec3, 2> rt_b;
  double k00 = 0.0, k01 = 0.0, k11 = 0.0;  ///< kg, inverse of the tangents' mobility
  double twist_mass = 0.0;                 ///< kg m^2; 0 for a single point
  std::array<double, 4> lever{};           ///< m, distance of a point from the centre
  std::array<double, 2> slide{};           ///< N s, both passes
  double twist = 0.0;                      ///< N m s, both passes

  bool loaded() const {
    return impulse[0] > 0.0 || impulse[1] > 0.0 || impulse[2] > 0.0 || impulse[3] > 0.0;
  }
};

/// A row's multipliers, or a change of them.
struct RowImpulses {
  std::array<double, 4> normal{};  ///< N s
  std::array<double, 2> slide{};   ///< N s
  double twist = 0.0;              ///< N m s
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

/// Change v and w of both bodies as the impulses do.
void apply_impulses(const ContactRow& row, const RowImpulses& impulses,
                    std::span<SolverBody> bodies);

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
