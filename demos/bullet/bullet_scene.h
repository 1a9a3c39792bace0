// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "demos/engine/engine.h"
#include "scenes/scene.h"

namespace tandem::demos {

/// A scene as plain data for another engine, made from the colliders of its world.
struct PlainScene {
  bench::Scene scene;
  std::vector<int> index;  ///< in `scene`, by shared body
  /// Shared body of each body of `scene`, or -1.
  std::vector<int> shared;
};

/// @throws std::invalid_argument naming body and rule if a body does not have exactly one collider
/// at
/// its centre, is moved by hand, or has a shape that plain scenes lack
PlainScene plain_scene(const Scene& scene);

}  // namespace tandem::demos
