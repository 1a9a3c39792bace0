// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/collision/shape.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/math.h"

namespace tandem::demos {

/// A box without a point: merged with another one it gives that one.
collision::Aabb empty_box();
bool is_empty(const collision::Aabb& box);

/// The smallest box, along the axes of the frame that `pose` is in, around a shape; for a height
/// field around its own box. Empty for a half-space, which has no end.
collision::Aabb extent(const collision::Shape& shape, const pbd::Pose& pose);

}  // namespace tandem::demos
