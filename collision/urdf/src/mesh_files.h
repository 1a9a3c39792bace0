// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "grouped_warnings.h"
#include "limit_count.h"
#include "tandem/urdf.h"

namespace tandem::urdf_files {

/// The meshes of a robot, as hulls: STL and OBJ files below the folders that the caller names. No
/// other file is opened.
class MeshFiles {
 public:
  MeshFiles(const UrdfOptions& options, scene_files::LimitCount& limits,
            scene_files::GroupedWarnings& warnings)
      : options_(options), limits_(limits), warnings_(warnings) {}

  /// @param link  names the link in warnings. @param file  as in the document
  /// @return null, with a warning, if the file is not read
  /// @throws std::invalid_argument  for a file that is read and invalid
  collision::Hull hull(const std::string& link, const std::string& file, const Vec3& scale);

 private:
  /// Empty if the file must not be opened.
  std::filesystem::path path_of(std::string_view file) const;
  const std::vector<Vec3>& points(const std::filesystem::path& path, bool stl);

  const UrdfOptions& options_;
  scene_files::LimitCount& limits_;
  scene_files::GroupedWarnings& warnings_;
  std::map<std::filesystem::path, std::vector<Vec3>> points_;
  std::map<std::pair<std::filesystem::path, std::array<double, 3>>, collision::Hull> hulls_;
};

}  // namespace tandem::urdf_files
