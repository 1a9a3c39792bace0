// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "obj_parser.h"
#include "tandem/collision/triangle_mesh.h"

namespace tandem::obj {

/// Cuts the faces of a file into triangles, so that each edge has one of them on either side. Its
/// inputs must outlive it.
class FaceCutter {
 public:
  enum class Fault : std::uint8_t {
    None,
    Shape,  ///< the face has no area, or intersects itself
    Area,   ///< one of its triangles has no area
    Edge,   ///< another triangle is on the same side of an edge
  };

  FaceCutter(std::span<const pbd::Vec3> vertices, std::span<const Face> faces);

  /// Appends its triangles. @param all  also those with a fault in area or edge
  Fault cut(const Face& face, bool all, std::vector<collision::TriangleMesh::Triangle>& out);

 private:
  using Triangle = collision::TriangleMesh::Triangle;

  /// A directed edge, by position.
  std::uint64_t edge(std::uint32_t from, std::uint32_t to) const {
    return std::uint64_t{place_[from]} << 32 | place_[to];
  }
  bool is_taken(std::uint32_t from, std::uint32_t to) const;
  /// Cuts a quad along its other diagonal if that is free.
  void cut_otherwise(std::span<const std::uint32_t> corners, std::span<Triangle> triangles) const;

  std::span<const pbd::Vec3> vertices_;
  std::vector<std::uint32_t> place_;            ///< the first vertex at the same position
  std::unordered_set<std::uint64_t> outlines_;  ///< edges of all faces
  std::unordered_set<std::uint64_t> used_;      ///< edges of triangles
};

}  // namespace tandem::obj
