// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/collision/shape.h"

namespace tandem::demos {

/// Triangles to draw a shape with, in its own frame. Corners of flat faces are not shared.
struct ShapeMesh {
  std::vector<float> positions;        ///< m, three for each corner
  std::vector<float> normals;          ///< unit, likewise
  std::vector<std::uint32_t> indices;  ///< three for each triangle, counter-clockwise from outside

  friend auto operator<=>(const ShapeMesh&, const ShapeMesh&) = default;
};

/// Half-spaces are drawn as a square of `extent` (m) around the foot of the origin.
ShapeMesh shape_mesh(const collision::Shape& shape, double extent = 10.0);

}  // namespace tandem::demos
