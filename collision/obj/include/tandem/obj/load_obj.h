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
  double scale = 1.0;  ///< m per unit of the file, > 0
  /// Limits of a file; errors use these names.
  std::size_t points = std::size_t{1} << 22;
  std::size_t triangles = std::size_t{1} << 22;
  /// Whether invalid faces are errors: no area, self-intersection, an edge with two triangles on
  /// one side. Otherwise they are left out.
  bool strict = false;
  /// Gets one entry per omitted face, with its line; null: none.
  std::vector<std::string>* warnings = nullptr;
};

/// Reads the faces of all groups and objects of a Wavefront OBJ file as one mesh. Faces are plane
/// polygons, convex or not, counter-clockwise seen from their fronts; they are cut into triangles.
/// Normals, texture coordinates, materials, lines and points are ignored.
///
/// Indices may be negative (relative to the last vertex so far). Quads are cut along the free
/// diagonal, else the shorter one.
/// @throws std::invalid_argument  naming file, line and rule: an unreadable file, a non-finite
///   coordinate, a corner without a vertex above it, no face at all (after omissions), and see
///   ObjOptions::strict
TANDEM_API collision::Mesh load_obj(const std::filesystem::path& path,
                                    const ObjOptions& options = {});

/// Like load_obj(), from memory.
/// @param name  stands for the file in messages
TANDEM_API collision::Mesh read_obj(std::istream& in, std::string_view name,
                                    const ObjOptions& options = {});
TANDEM_API collision::Mesh parse_obj(std::string_view text, std::string_view name,
                                     const ObjOptions& options = {});

}  // namespace tandem::obj
