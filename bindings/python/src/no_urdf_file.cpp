// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "robot_file.h"

namespace tandem::python {

SceneFile load_urdf_file(const std::filesystem::path& path, RobotOptions) {
  throw SceneFileError(path.string() +
                       ": this build has no reader of URDF (-DTANDEM_WITH_URDF=ON)");
}

}  // namespace tandem::python
