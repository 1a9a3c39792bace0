// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"

namespace tandem::obj {

/// Appends the triangles of a plane polygon, convex or not, by ear clipping, shortest cut first.
/// Source: [ericson2005] Sec. 12.5.
/// @return false if the polygon has no area or intersects itself; `out` is then invalid
bool triangulate(std::span<const pbd::Vec3> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<collision::TriangleMesh::Triangle>& out);

}  // namespace tandem::obj
