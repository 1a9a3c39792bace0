// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "contact_rows.h"
#include "tandem/pbd/contact.h"

namespace tandem::pbd {

/// Sets frame and arms of a contact for the poses at the start of the step, and its forces as
/// impulses. Responses are prepared for all lanes together (ContactKernels::prepare).
void set_row(const Contact& contact, std::span<const SolverBody> bodies, const Vec3& gravity,
             ContactRows& rows, std::size_t lane);

/// Sets the part that changes as bodies turn: arms, and the points about their centre.
void set_arms(const Contact& contact, std::span<const SolverBody> bodies, ContactRows& rows,
              std::size_t lane);

/// Fills unused lanes with the first one.
void repeat_first_row(ContactRows& rows);

/// Share of its impulses that a row carries on, see kGrowth.
double warm_start_scale(const ContactRows& rows, std::size_t lane, double growth);

/// N s, world, on body b.
Vec3 friction_of(const ContactRows& rows, std::size_t lane);

/// View of bodies for the kernels.
BodyNumbers numbers_of(std::span<SolverBody> bodies);

/// View of contacts for the kernels.
AnchorNumbers anchors_of(std::span<const Contact> contacts);

/// Gap of point i at the current poses, m.
double gap_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b, int i);

/// Lever arms (m, world) from both centres of mass to a common point of contact, so that a pair of
/// opposite impulses conserves angular momentum.
struct ContactArms {
  std::array<Vec3, 4> a;
  std::array<Vec3, 4> b;
  std::array<double, 4> gap{};  ///< m
};
ContactArms arms_of(const Manifold& manifold, const SolverBody& a, const SolverBody& b);

/// Cuts impulses that rows carry on to bodies with joints, whose predicted poses must stay near.
/// @pre ContactKernels::begin
void carry_near(ContactRows& rows, const SubstepContext& ctx);

}  // namespace tandem::pbd
