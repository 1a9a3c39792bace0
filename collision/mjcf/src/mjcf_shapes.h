// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>
#include <optional>

#include "limit_count.h"
#include "mjcf_model.h"
#include "tandem/collision/shape.h"
#include "tandem/mjcf.h"

namespace tandem::mjcf {

/// The shapes of geoms that collide.
class Shapes {
 public:
  Shapes(Model& model, const MjcfOptions& options, scene_files::LimitCount& limits)
      : model_(model), options_(options), limits_(limits) {}

  /// Nothing, with a warning, of a geom that is not read.
  /// @throws SceneFileError
  std::optional<collision::Shape> of(int geom);

 private:
  collision::Hull mesh(int geom);
  collision::Hull ellipsoid(int geom);
  collision::Field field(int geom);

  Model& model_;
  const MjcfOptions& options_;
  scene_files::LimitCount& limits_;
  std::map<int, collision::Hull> meshes_;
};

/// From a geom's centre to the origin of its shape: a height field starts at its lowest corner.
Vec3 origin_of(const mjModel& model, int geom);

}  // namespace tandem::mjcf
