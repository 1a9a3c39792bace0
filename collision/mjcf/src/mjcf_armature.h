// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "mjcf_joints.h"

namespace tandem::mjcf {

/// How a body is carried, and so which rotors on its joints are the same as more inertia of it.
enum class Carrier : std::uint8_t {
  Fixed,   ///< to the world
  Slides,  ///< it moves, but never turns
  Turns,
};

/// What joints make of a body whose parent is carried so.
Carrier carried(const mjModel& model, JointRange joints, Carrier parent);

/// Armature is inertia of a coordinate: that of a rotor with a gear. Where the coordinate's speed
/// is the body's own in the world it is added to the body, and nothing moves otherwise than with
/// the rotor. Elsewhere it is left out, and told.
/// @param joints  between the body and its parent
/// @param parent  how that is carried
void add_armature(Model& model, JointRange joints, Carrier parent, pbd::BodyDef& def);

}  // namespace tandem::mjcf
