// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// The first of the paper's two steps, [friston] Secs. 4.2 and 4.6: move a body towards the mean of
/// its remote states, or to its owner's state, before it is simulated. Poses are set; velocities
/// are averaged independently of them.
/// @param dt          s, of the step to come
/// @param thresholds  see PeerOptions::two_step_thresholds; not used for an owner's state
/// @return the correction made
pbd::Correction average_state(pbd::World& world, const pbd::PoseTarget& target, double dt,
                              bool thresholds);

/// Whether a body has been at rest and in agreement, within the solver's limits for sleep, for as
/// long as the solver waits before it puts a body to sleep. Setting a pose wakes: a body that is
/// corrected in each step would never sleep, while the solver's targets let it.
/// @param dt  s, since the last call     @param[in,out] still  s, duration of that state
bool rests(const pbd::World& world, const pbd::PoseTarget& target, double dt, double& still);

}  // namespace tandem::consensus
