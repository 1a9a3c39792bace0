// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scene_view/load_file.h"

#include <algorithm>
#include <cctype>

#include "arguments/arguments.h"

namespace tandem::demos {

namespace {

void require_format(bool fits, bool given, std::string_view option, std::string_view format,
                    const std::string& file) {
  if (given && !fits) refuse(option, file, "left out unless the file is " + std::string(format));
}

}  // namespace

SceneFile load_file(const FileOptions& options) {
  const std::string file = options.path.string();
  std::string ending = options.path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool urdf = ending == ".urdf", mjcf = ending == ".xml" || ending == ".mjcf";
  require_format(urdf, !options.package_root.empty(), "--package-root", "URDF", file);
  require_format(urdf, !options.fixed_base, "--free-base", "URDF", file);
  require_format(mjcf, !options.keyframe.empty(), "--keyframe", "MJCF", file);
  if (urdf) return load_urdf_file(options);
  if (mjcf) return load_mjcf_file(options);
  if (ending != ".json" && ending != ".gltf" && ending != ".glb") {
    refuse("--scene", file, "a file that ends in .json, .gltf, .glb, .urdf, .xml or .mjcf");
  }
  return load_scene(options.path);
}

}  // namespace tandem::demos
