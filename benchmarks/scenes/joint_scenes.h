// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/scene.h"

namespace tandem::bench {

/// Scenes of joints: Box3D's benchmarks and samples, and parts of games. Dolls: human, dropped from
/// 1 m; rain, groups of three dropped from 20 m on a grid with a torus in each cell; wedge, dropped
/// into a groove. joint_grid: rows of balls in a hanging net; ball_and_chain: links, and a ball of
/// 33.5 t; bridge: planks, and a car; crane: cable links with a ball of 2 t that swings into a
/// wall; doors: with motors between stops.
inline constexpr std::array<std::string_view, 8> kJointScenes{
    "human", "rain", "wedge", "joint_grid", "ball_and_chain", "bridge", "crane", "doors"};

bool is_joint_scene(std::string_view name);

/// @param size  number of the scene's elements, see above; 0: as in the tables
/// @throws std::invalid_argument if no scene has that name
Scene joint_scene(std::string_view name, int size = 0);

}  // namespace tandem::bench
