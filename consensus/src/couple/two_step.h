// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// The first of the paper's two steps, [friston] Secs. 4.2 and 4.6: move a body towards the mean of
/// its remote states before it is simulated, or to where its owner has it; poses are set,
/// velocities are averaged and know nothing of it.
/// @param dt          s, of the step to come
/// @param thresholds  see PeerOptions::two_step_thresholds; not of an owner's state
/// @return what was done
pbd::Correction average_state(pbd::World& world, const pbd::PoseTarget& target, double dt,
                              bool thresholds);

/// Whether a body has been at rest and in agreement, within the solver's own limits for sleep, for
/// as long as the solver waits before it puts a body to sleep. Setting a pose wakes: what goes on
/// being corrected never sleeps, where the solver's targets let it.
/// @param dt  s, since the last call     @param[in,out] still  s, for how long it has been so
bool rests(const pbd::World& world, const pbd::PoseTarget& target, double dt, double& still);

}  // namespace tandem::consensus
