// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string_view>

namespace tandem::scene_files {

/// Sources of a glTF document's buffers, besides itself.
struct GltfSources {
  std::filesystem::path folder;  ///< of files that it names; nothing outside is read
  std::string_view binary = {};  ///< binary chunk of its container
};

/// A binary glTF (.glb), or only text. Views of the input.
struct GltfContainer {
  std::string_view document;
  std::string_view binary;

  /// @param bytes  must outlive the result
  /// @throws SceneFileError  if a length does not match the input
  static GltfContainer of(std::string_view bytes, std::string_view file);
};

}  // namespace tandem::scene_files
