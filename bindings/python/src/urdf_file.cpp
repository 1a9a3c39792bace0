// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <utility>

#include "robot_file.h"
#include "tandem/urdf.h"

namespace tandem::python {

SceneFile load_urdf_file(const std::filesystem::path& path, RobotOptions options) {
  UrdfOptions urdf;
  urdf.scene = options.scene;
  urdf.fixed_base = options.fixed_base;
  urdf.packages = std::move(options.packages);
  urdf.packages.try_emplace("", path.has_parent_path() ? path.parent_path() : ".");
  return load_urdf(path, urdf);
}

}  // namespace tandem::python
