// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/scene.h"

namespace tandem::bench {

inline constexpr int kDollBodies = 14;
inline constexpr int kDollJoints = 13;

/// A ragdoll of 137 kg with nine ball joints with cones and four hinges, all with dry friction.
/// Bodies with a common joint, and the thighs with each other and with the belly, do not collide.
/// @param frame  between the feet: x forward, y left, z up
void add_doll(Scene& scene, const Pose& frame);

}  // namespace tandem::bench
