// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/collision/shape.h"
#include "tandem/pbd/export.h"

namespace tandem::obj {

struct TANDEM_API ObjOptions {
  double scale = 1.0;  ///< m for each unit of the file, > 0
  /// The most that a file may have; what has more is refused by these names.
  std::size_t points = std::size_t{1} << 22;
  std::size_t triangles = std::size_t{1} << 22;
  /// Whether faults of faces are errors: no area, one that crosses itself, an edge with two
  /// triangles on one side. Else what has a fault is left out.
  bool strict = false;
  /// Where it is told what was left out, with its lines, one entry a fault; null: nowhere.
  std::vector<std::string>* warnings = nullptr;
};

/// The faces of all groups and objects of a Wavefront OBJ file as one mesh. Faces are plane
/// polygons, convex or not, counter-clockwise seen from their fronts; they are cut into triangles.
/// Normals, texture coordinates, materials, lines and points are passed over.
///
/// Indices may be negative (counted back from the last vertex so far). Quads are cut along the
/// diagonal that is free, else the shorter one.
/// @throws std::invalid_argument  naming file, line and rule: a file that cannot be read, a
///   coordinate that is no finite number, a corner that names no vertex above it, no face (that is
///   not left out) at all, and what ObjOptions::strict says
TANDEM_API collision::Mesh load_obj(const std::filesystem::path& path,
                                    const ObjOptions& options = {});

/// The same from memory.
/// @param name  stands for the file in messages
TANDEM_API collision::Mesh read_obj(std::istream& in, std::string_view name,
                                    const ObjOptions& options = {});
TANDEM_API collision::Mesh parse_obj(std::string_view text, std::string_view name,
                                     const ObjOptions& options = {});

}  // namespace tandem::obj
