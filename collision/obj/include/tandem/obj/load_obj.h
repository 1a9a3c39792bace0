// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <string_view>

#include "tandem/collision/shape.h"
#include "tandem/pbd/export.h"

namespace tandem::obj {

struct TANDEM_API ObjOptions {
  double scale = 1.0;  ///< m for each unit of the file, > 0
  /// The most that a file may have; what has more is refused by these names.
  std::size_t points = std::size_t{1} << 22;
  std::size_t triangles = std::size_t{1} << 22;
};

/// The faces of all groups and objects of a Wavefront OBJ file as one mesh. Faces are plane
/// polygons, convex or not, counter-clockwise seen from their fronts; they are cut into triangles.
/// Normals, texture coordinates, materials, lines and points are passed over.
///
/// Indices may be negative (counted back from the last vertex so far). What TriangleMesh::make
/// refuses is refused here.
/// @throws std::invalid_argument  naming file, line and rule: a file that cannot be read, a
///   coordinate that is no finite number, a corner that names no vertex above it, a face that has
///   no area or crosses itself, no face at all
TANDEM_API collision::Mesh load_obj(const std::filesystem::path& path,
                                    const ObjOptions& options = {});

/// The same from memory.
/// @param name  stands for the file in messages
TANDEM_API collision::Mesh read_obj(std::istream& in, std::string_view name,
                                    const ObjOptions& options = {});
TANDEM_API collision::Mesh parse_obj(std::string_view text, std::string_view name,
                                     const ObjOptions& options = {});

}  // namespace tandem::obj
