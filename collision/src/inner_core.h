// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "collider.h"

namespace tandem::collision {

/// A convex collider's shape in the frame of its body.
ConvexCore body_core(const Collider& c);

/// m, how thick the layer is that inner_core() takes off.
inline double inner_layer(const Collider& c) { return 0.25 * c.size; }

/// What is left of it where a layer is taken off all round, as thick as a quarter of its least
/// extent or, towards the middle, half as deep as the solid is there: what rests or is pushed into
/// something never comes so far that this touches.
/// @param arms  memory for a hull's corners; the core points there
ConvexCore inner_core(const Collider& c, std::vector<Vec3>& arms);

}  // namespace tandem::collision
