// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/urdf.h"

#include "arguments/arguments.h"
#include "scene_view/load_file.h"

namespace tandem::demos {

SceneFile load_urdf_file(const FileOptions& options) {
  UrdfOptions urdf;
  urdf.fixed_base = options.fixed_base;
  const std::filesystem::path folder = options.path.parent_path();
  urdf.packages[""] = folder.empty() ? "." : folder;
  if (!options.package_root.empty()) {
    if (!std::filesystem::is_directory(options.package_root)) {
      refuse("--package-root", options.package_root.string(), "a folder");
    }
    for (const auto& entry : std::filesystem::directory_iterator(options.package_root)) {
      if (entry.is_directory()) urdf.packages[entry.path().filename().string()] = entry.path();
    }
  }
  return load_urdf(options.path, urdf);
}

}  // namespace tandem::demos
