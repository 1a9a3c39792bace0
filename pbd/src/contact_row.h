// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "contact_rows.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

/// Frame and arms of a contact for the poses of the step's start, its forces as impulses. Its
/// responses are prepared for all lanes together (ContactKernels::prepare).
void set_row(const Contact& contact, std::span<const SolverBody> bodies, const Vec3& gravity,
             ContactRows& rows, std::size_t lane);

/// The part of it that changes as bodies turn: arms, and where the points lie about their centre.
void set_arms(const Contact& contact, std::span<const SolverBody> bodies, ContactRows& rows,
              std::size_t lane);

/// Lanes that are not in use repeat the first one.
void repeat_first_row(ContactRows& rows);

/// Share of its impulses that a row hands on, see kGrowth.
double warm_start_scale(const ContactRows& rows, std::size_t lane, double growth);

/// N s, world, on body b.
Vec3 friction_of(const ContactRows& rows, std::size_t lane);

/// Of bodies, for the kernels.
BodyNumbers numbers_of(std::span<SolverBody> bodies);

/// Of contacts, likewise.
AnchorNumbers anchors_of(std::span<const Contact> contacts);

/// Gap of point i as the bodies stand, m.
double gap_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b, int i);

/// Lever arms (m, world) from both centres of mass to a common point of contact, so that a pair of
/// opposite impulses keeps angular momentum.
struct ContactArms {
  std::array<Vec3, 4> a;
  std::array<Vec3, 4> b;
  std::array<double, 4> gap{};  ///< m
};
ContactArms arms_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b);

/// Cut what rows hand on to bodies on joints: where these are predicted they must be near.
/// @pre ContactKernels::begin
void carry_near(ContactRows& rows, const SubstepContext& ctx);

}  // namespace tandem::pbd
