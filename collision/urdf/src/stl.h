// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::urdf_files {

/// The triangle corners of an STL file, binary or text, without duplicates, in the order of first
/// appearance. Normals, colours and names are ignored.
/// @param name  stands for the file in messages
/// @param most  limit of triangles
/// @throws std::invalid_argument  naming file, triangle and rule: a length that does not match the
///   number of triangles, an unexpected word, a non-finite coordinate
std::vector<pbd::Vec3> stl_points(std::string_view bytes, std::string_view name, std::size_t most);

}  // namespace tandem::urdf_files
