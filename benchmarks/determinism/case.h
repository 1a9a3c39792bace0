// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/scene.h"

namespace tandem::determinism {

/// Settings of a run; `lanes` must not change a bit.
struct Run {
  int steps = 600;  ///< of 1/60 s
  int lanes = 0;    ///< contact rows solved at once: pbd::ContactOptions
  bool sleeping = true;
};

SceneOptions scene_options(const Run& run);

/// Hinges, sliders and balls with motors, limits and springs, one of which breaks; damped bodies.
void build_machine(Scene& scene);
/// Every shape and a compound, dropped on a mesh and on a height field.
void build_shapes(Scene& scene);

/// Hash of the worlds of three peers that carry a plate of cubes over links with jitter and loss.
std::uint64_t run_session(const Run& run);

}  // namespace tandem::determinism
