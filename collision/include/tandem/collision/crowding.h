// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Whether more than `most` pairs of colliders that may meet have boxes that meet, as bodies stand
/// now: what the next step would look at, found without a step and in time that `most` bounds. For
/// scenes of strangers. Half-spaces are left out, which meet each body once.
TANDEM_API bool is_crowded(const CollisionScene& scene, const pbd::World& world, std::size_t most);

}  // namespace tandem::collision
