// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string>

#include "tandem/scene_files.h"

namespace tandem::demos {

struct FileOptions {
  std::filesystem::path path;
  /// Of URDF: package://NAME/ is folder NAME in it; empty: no packages.
  std::filesystem::path package_root;
  bool fixed_base = true;  ///< of URDF
  std::string keyframe;    ///< of MJCF
};

/// A scene by the ending of its file: .json, .gltf, .glb, .urdf, .xml or .mjcf. Relative names of
/// meshes in URDF are those of the file's folder.
/// @throws UsageError for another ending, or an option of another format; SceneFileError, also if
///   this build lacks the reader
SceneFile load_file(const FileOptions& options);

// For load_file().
SceneFile load_urdf_file(const FileOptions& options);
SceneFile load_mjcf_file(const FileOptions& options);

}  // namespace tandem::demos
