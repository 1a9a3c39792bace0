// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string_view>

namespace tandem::scene_files {

/// What a glTF document may take its buffers from, beside itself.
struct GltfSources {
  std::filesystem::path folder;  ///< of files that it names; nothing outside it is read
  std::string_view binary = {};  ///< of its container, behind the document
};

/// A binary glTF (.glb), or the text alone. Views of what was read.
struct GltfContainer {
  std::string_view document;
  std::string_view binary;

  /// @param bytes  outlives the result
  /// @throws SceneFileError  where a length is not that of what is there
  static GltfContainer of(std::string_view bytes, std::string_view file);
};

}  // namespace tandem::scene_files
