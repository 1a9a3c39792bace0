// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "robot_file.h"
#include "tandem/mjcf.h"

namespace tandem::python {

SceneFile load_mjcf_file(const std::filesystem::path& path, const RobotOptions& options) {
  MjcfOptions mjcf;
  mjcf.scene = options.scene;
  mjcf.keyframe = options.keyframe;
  return load_mjcf(path, mjcf);
}

}  // namespace tandem::python
