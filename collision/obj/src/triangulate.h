// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"

namespace tandem::obj {

/// Append the triangles of a plane polygon, convex or not: ears are cut off, the one with the
/// shortest cut first. Source: [ericson2005] Sec. 12.5.
/// @return false where the polygon has no area or crosses itself; `out` is then of no use
bool triangulate(std::span<const pbd::Vec3> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<collision::TriangleMesh::Triangle>& out);

}  // namespace tandem::obj
