// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// The first of the paper's two steps, [friston] Secs. 4.2 and 4.6: move a body towards the mean of
/// its remote states before it is simulated. Differences below the sleeping threshold stay.
/// @param dt  s, of the step to come     @return what was done
pbd::Correction average_state(pbd::World& world, const pbd::PoseTarget& target, double dt);

}  // namespace tandem::consensus
