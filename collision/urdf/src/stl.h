// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::urdf_files {

/// The corners of the triangles of an STL file, binary or text: those that are the same once, in
/// the order in which they first come. Normals, colours and names are passed over.
/// @param name  stands for the file in messages
/// @param most  triangles
/// @throws std::invalid_argument  naming file, triangle and rule: a length that is not that of its
///   triangles, a word that does not belong there, a coordinate that is no finite number
std::vector<pbd::Vec3> stl_points(std::string_view bytes, std::string_view name, std::size_t most);

}  // namespace tandem::urdf_files
