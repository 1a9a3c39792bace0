// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "demos/engine/scene.h"
#include "tandem/pbd/world.h"

namespace tandem::bench {

/// @param ids  of the scene's bodies, in their order
/// @throws std::invalid_argument for a kind of joint that this build lacks
void add_joints(pbd::World& world, const Scene& scene, std::span<const pbd::BodyId> ids);

}  // namespace tandem::bench
