// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "place.h"

namespace tandem::scene_files {

/// The corners and triangles of a glTF document's meshes. Buffers are read when they are asked for.
class GltfBuffers {
 public:
  /// @param folder  of files that the document names; nothing outside it is read
  GltfBuffers(const Place& document, std::filesystem::path folder)
      : document_(document), folder_(std::move(folder)) {}

  struct Mesh {
    std::vector<Vec3> points;
    std::vector<collision::TriangleMesh::Triangle> triangles;
  };
  /// All primitives of the mesh that `index` names.
  Mesh mesh(const Place& index);

 private:
  /// Numbers of an accessor, `width` for each of its elements.
  std::vector<double> numbers(const Place& index, const char* type, std::size_t width);
  const std::string& bytes(const Place& index);
  void add(const Place& primitive, Mesh& out);

  const Place& document_;
  std::filesystem::path folder_;
  std::map<std::int64_t, std::string> buffers_;
};

}  // namespace tandem::scene_files
