// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scene_view/load_file.h"

namespace tandem::demos {

SceneFile load_urdf_file(const FileOptions& options) {
  throw SceneFileError(options.path.string() +
                       ": this build has no reader of URDF (-DTANDEM_WITH_URDF=ON)");
}

}  // namespace tandem::demos
