// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "demos/engine/engine.h"
#include "scenes/scene.h"

namespace tandem::demos {

/// A scene as plain data for another engine, from the colliders of its world.
struct PlainScene {
  bench::Scene scene;
  std::vector<int> index;  ///< in `scene`, by shared body
  /// By body of `scene`: the shared body, or -1.
  std::vector<int> shared;
};

/// @throws std::invalid_argument naming body and rule where a body has not exactly one collider in
///   its centre, is moved by hand, or has a shape that plain scenes do not have
PlainScene plain_scene(const Scene& scene);

}  // namespace tandem::demos
