// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/scene.h"

namespace tandem::determinism {

/// How a case is run; `lanes` may not change a bit.
struct Run {
  int steps = 600;  ///< of 1/60 s
  int lanes = 0;    ///< contact rows solved at once: pbd::ContactOptions
  bool sleeping = true;
};

SceneOptions scene_options(const Run& run);

/// Hinges, sliders and balls with motors, limits and springs, one of which breaks; damped bodies.
void build_machine(Scene& scene);
/// Every shape and a compound, dropped on a mesh and on a field of heights.
void build_shapes(Scene& scene);

/// Three peers at links with jitter and loss, who carry one plate of cubes: the hash of their
/// worlds.
std::uint64_t run_session(const Run& run);

}  // namespace tandem::determinism
