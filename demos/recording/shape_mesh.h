// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <vector>

#include "tandem/collision/shape.h"

namespace tandem::demos {

/// Triangles of a shape, in its own frame. Flat faces share no corners.
struct ShapeMesh {
  std::vector<float> positions;        ///< m, three per corner
  std::vector<float> normals;          ///< unit length, three per corner
  std::vector<std::uint32_t> indices;  ///< three per triangle, counter-clockwise from outside

  friend auto operator<=>(const ShapeMesh&, const ShapeMesh&) = default;
};

/// A half-space becomes a square of `extent` (m) around the point nearest to the origin.
ShapeMesh shape_mesh(const collision::Shape& shape, double extent = 10.0);

}  // namespace tandem::demos
