// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Whether the boxes of more than `most` pairs of colliders that may meet overlap at the current
/// poses, a bound on the work of the next step. Its own time is bounded by `most`. For scenes from
/// untrusted sources. Half-spaces, which meet each body once, are left out.
TANDEM_API bool is_crowded(const CollisionScene& scene, const pbd::World& world, std::size_t most);

}  // namespace tandem::collision
