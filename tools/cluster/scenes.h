// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/world.h"

namespace tandem::cluster_tool {

/// A body with its shapes; `stable_id` is its number.
struct SceneBody {
  pbd::BodyDef def;
  std::vector<collision::ColliderDef> colliders;
};

/// A scene by function: any rank makes any body.
struct Scene {
  std::string name;
  std::size_t bodies = 0;
  std::vector<SceneBody> fixed;                ///< static bodies, on all ranks
  std::function<SceneBody(std::size_t)> body;  ///< argument below `bodies`
};

std::span<const std::string_view> scene_names();

/// @param size  of "cliff": balls, a thousand per 4.5 m of edge; of "edge": the same, with walls at
///   the last balls, for equal density at any size; of "cubes": stacks of five; of "heap": balls
///   and
///   boxes, a thousand per 6 m^2 of a pit; of "pyramid": cubes in its lowest row; 0: 1000 balls,
///   100
///   stacks, 1000 bodies, 20 cubes
/// @throws std::invalid_argument if there is no such scene
Scene make_scene(std::string_view name, std::size_t size);

}  // namespace tandem::cluster_tool
