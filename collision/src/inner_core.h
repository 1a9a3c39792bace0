// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "collider.h"

namespace tandem::collision {

/// A convex collider's shape in the frame of its body.
ConvexCore body_core(const Collider& c);

/// m, thickness of the layer that inner_core() removes.
inline double inner_layer(const Collider& c) { return 0.25 * c.size; }

/// The shape without a layer all round: a quarter of its least extent thick or, towards the middle,
/// half as thick as the solid is deep there. A body that rests or is pushed into something never
/// sinks so deep that this touches.
/// @param arms  memory for a hull's corners; the core points there
ConvexCore inner_core(const Collider& c, std::vector<Vec3>& arms);

}  // namespace tandem::collision
