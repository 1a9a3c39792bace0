// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/coupling.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// Pull a dynamic body towards its target during the step to come, see VirtualCouplingOptions.
/// @param dt  s, of that step
void pull_towards(pbd::World& world, const pbd::PoseTarget& target, double dt,
                  const VirtualCouplingOptions& options);

}  // namespace tandem::consensus
