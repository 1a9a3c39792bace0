// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <tuple>
#include <vector>

#include "gltf_buffers.h"

namespace tandem::scene_files {

/// Shapes of a glTF document's meshes. Equal shapes are shared.
class GltfMeshes {
 public:
  GltfMeshes(const Place& document, const GltfSources& sources)
      : document_(document), buffers_(document, sources) {}

  /// The shape of all primitives of the mesh that `index` names.
  /// @param hull  make their convex hull, else the surface
  collision::Shape shape(const Place& index, const Vec3& scale, bool hull);

 private:
  struct Mesh {
    std::vector<Vec3> points;
    std::vector<collision::TriangleMesh::Triangle> triangles;
  };
  /// Mesh, bits of its scale, and whether it is a hull.
  using Key = std::tuple<std::int64_t, std::array<std::uint64_t, 3>, bool>;

  const Mesh& mesh(const Place& index);
  void add(const Place& primitive, Mesh& out);

  const Place& document_;
  GltfBuffers buffers_;
  std::map<std::int64_t, Mesh> meshes_;
  std::map<Key, collision::Shape> shapes_;
};

}  // namespace tandem::scene_files
