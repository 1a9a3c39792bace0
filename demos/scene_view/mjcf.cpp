// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mjcf.h"

#include "scene_view/load_file.h"

namespace tandem::demos {

SceneFile load_mjcf_file(const FileOptions& options) {
  MjcfOptions mjcf;
  mjcf.keyframe = options.keyframe;
  return load_mjcf(options.path, mjcf);
}

}  // namespace tandem::demos
