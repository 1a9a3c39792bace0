// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Robots from files, if this build has their readers.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "tandem/scene_files.h"

namespace tandem::python {

/// Keywords of Scene.load(), of which each format has its own.
struct RobotOptions {
  SceneOptions scene = {};
  std::map<std::string, std::filesystem::path, std::less<>> packages = {};  ///< of URDF
  bool fixed_base = true;                                                   ///< of URDF
  std::string keyframe = {};                                                ///< of MJCF
};

/// Relative names of meshes are those of the file's folder, unless the packages have "".
/// @throws SceneFileError, also where the build lacks the reader
SceneFile load_urdf_file(const std::filesystem::path& path, RobotOptions options);
/// One call at a time in a process: under the GIL. @throws as above
SceneFile load_mjcf_file(const std::filesystem::path& path, const RobotOptions& options);

}  // namespace tandem::python
