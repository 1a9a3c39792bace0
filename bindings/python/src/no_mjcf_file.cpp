// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "robot_file.h"

namespace tandem::python {

SceneFile load_mjcf_file(const std::filesystem::path& path, const RobotOptions&) {
  throw SceneFileError(path.string() +
                       ": this build has no reader of MJCF (-DTANDEM_WITH_MJCF=ON)");
}

}  // namespace tandem::python
