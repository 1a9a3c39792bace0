// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/body.h"

namespace tandem::pbd {

/// @param inertia  kg m^2, symmetric
PrincipalAxes principal_axes(const Mat3& inertia);

/// Torque-free rotation over h (s). Conserves angular momentum and energy to rounding, at any spin.
/// Exact if two principal moments are equal; else of fourth order, fast spin in parts, up to 1024
/// of them. Above that, some 1e5 rad/s, the phase is lost.
/// @param w_l  rad/s, frame of the body: in, at the start; out, at the end
Quat free_rotation(const Quat& q, const PrincipalAxes& axes, Vec3& w_l, double h);

}  // namespace tandem::pbd
