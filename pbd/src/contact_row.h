// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "contact_rows.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

/// How gaps become velocities in a substep.
struct SubstepRule {
  double push_gain = 0.0;       ///< share of an overlap opened in a substep
  double push_speed = 0.0;      ///< m/s, at most
  double push_slop = 0.0;       ///< m, overlap that is left alone
  double warm_start_gap = 0.0;  ///< m, carried impulses of wider gaps are dropped
  double bounce_speed = 0.0;    ///< m/s, slower impacts do not bounce
  Vec3 gravity = Vec3::Zero();  ///< m/s^2
};

/// Frame and arms of a contact for the poses of the step's start. Its responses are prepared for
/// all lanes together (ContactKernels::prepare).
void set_row(const Contact& contact, std::span<const SolverBody> bodies, ContactRows& rows,
             std::size_t lane);

/// Lanes that are not in use repeat the first one: after set_row() and after begin_row().
void repeat_first_frame(ContactRows& rows);
void repeat_first_state(ContactRows& rows);

/// Gaps and velocities of the substep's start. Friction is carried from substep to substep, which
/// heaps need, but starts anew in each step: carried on, it never comes to rest.
void begin_row(const Contact& contact, const SubstepRule& rule, double h,
               std::span<const SolverBody> bodies, ContactRows& rows, std::size_t lane);

/// Share of its impulses that a row hands on: an impact is no load, and replayed in the next
/// substep it would throw off again what has just landed. A load builds up over a few substeps
/// instead.
double share_to_carry(const ContactRows& rows, std::size_t lane, double gravity, double h);

/// N s, world, on body b.
Vec3 friction_of(const ContactRows& rows, std::size_t lane);

/// Of bodies, for the kernels.
BodyNumbers numbers_of(std::span<SolverBody> bodies);

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
