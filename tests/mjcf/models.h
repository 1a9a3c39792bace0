// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "tandem/mjcf.h"

namespace mjcf_test {

/// A model with this content of <mujoco>.
inline tandem::SceneFile model(const std::string& inside) {
  return tandem::parse_mjcf("<mujoco>" + inside + "</mujoco>");
}
/// A model with this content of <worldbody>.
inline tandem::SceneFile world(const std::string& inside) {
  return model(std::string("<worldbody>") + inside + "</worldbody>");
}
/// Steps at 240 Hz. @param seconds  s
inline void run(tandem::SceneFile& file, double seconds) {
  for (long i = std::lround(seconds * 240.0); i > 0; --i) file.scene.step(1.0 / 240.0);
}
/// Whether a warning has this in it.
inline bool is_told(const tandem::SceneFile& file, const std::string& what) {
  return std::any_of(file.warnings.begin(), file.warnings.end(), [&](const std::string& warning) {
    return warning.find(what) != std::string::npos;
  });
}

}  // namespace mjcf_test
