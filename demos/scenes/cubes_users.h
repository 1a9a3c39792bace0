// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "scenes/cubes.h"

namespace tandem::demos {

/// The script of user A (0) or B (1). Seeds vary starts and paths by up to 0.1 s and a few
/// centimetres. The tasks keep a reference to the scene.
std::vector<HandTask> cubes_tasks(std::size_t user, const CubesOptions& cubes, const Scene& scene,
                                  const UserOptions& options);

}  // namespace tandem::demos
