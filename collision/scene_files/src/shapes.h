// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "place.h"

namespace tandem::scene_files {

json write_shape(const collision::Shape& shape);

/// Reads points from an array of arrays of three numbers.
std::vector<Vec3> read_points(const Place& at);

}  // namespace tandem::scene_files
