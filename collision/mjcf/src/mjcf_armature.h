// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "mjcf_joints.h"

namespace tandem::mjcf {

/// How a body is carried, which tells the joints whose rotors are equivalent to inertia of the
/// body.
enum class Carrier : std::uint8_t {
  Fixed,   ///< to the world
  Slides,  ///< it translates, but never turns
  Turns,
};

/// How a body is carried, given its joints and how its parent is.
Carrier carried(const mjModel& model, JointRange joints, Carrier parent);

/// Armature is inertia of a coordinate: that of a geared rotor. If the coordinate's speed is the
/// body's own in the world, it is added to the body, which moves as with the rotor. Otherwise it is
/// left out, with a warning.
/// @param joints  between the body and its parent
/// @param parent  how the parent is carried
void add_armature(Model& model, JointRange joints, Carrier parent, pbd::BodyDef& def);

}  // namespace tandem::mjcf
