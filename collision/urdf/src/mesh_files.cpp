// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mesh_files.h"

#include <algorithm>

#include "nearest_hull.h"
#include "read_bytes.h"
#include "stl.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/obj/load_obj.h"

namespace tandem::urdf_files {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const fs::path& path) {
  std::string out = path.extension().string();
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

/// Whether `path` is below `folder`; both are canonical.
bool is_below(const fs::path& folder, const fs::path& path) {
  const auto [end, at] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return (end == folder.end() || (end->empty() && std::next(end) == folder.end())) &&
         at != path.end();
}

/// The triangle corners of an OBJ file.
std::vector<Vec3> obj_points(const fs::path& path, const SceneLimits& limits) {
  const collision::Mesh mesh =
      obj::parse_obj(scene_files::read_bytes(path), path.string(),
                     {.points = limits.points, .triangles = limits.triangles});
  const auto vertices = mesh->vertices();
  return {vertices.begin(), vertices.end()};
}

}  // namespace

fs::path MeshFiles::path_of(std::string_view file) const {
  constexpr std::string_view kScheme = "package://";
  std::string_view package;
  if (file.starts_with(kScheme)) {
    file.remove_prefix(kScheme.size());
    const std::size_t slash = file.find('/');
    if (slash == file.npos) return {};
    package = file.substr(0, slash);
    if (package.empty()) return {};
    file.remove_prefix(slash + 1);
  }
  const auto root = options_.packages.find(package);
  const fs::path name(file);
  if (root == options_.packages.end() || name.is_absolute() || file.find(':') != file.npos) {
    return {};
  }
  // Symbolic links and ".." are resolved before the check.
  std::error_code failed;
  const fs::path folder = fs::canonical(root->second, failed);
  if (failed) return {};
  const fs::path path = fs::canonical(folder / name, failed);
  return !failed && is_below(folder, path) && fs::is_regular_file(path, failed) ? path : fs::path();
}

const std::vector<Vec3>& MeshFiles::points(const fs::path& path, bool stl) {
  const auto [known, fresh] = points_.try_emplace(path);
  if (!fresh) return known->second;
  std::vector<Vec3>& out = known->second;
  out = stl ? stl_points(scene_files::read_bytes(path), path.string(), options_.limits.triangles)
            : obj_points(path, options_.limits);
  return out;
}

collision::Hull MeshFiles::hull(const std::string& link, const std::string& file,
                                const Vec3& scale) {
  const std::string title = link + " (" + file + ")";
  const auto pass_over = [&](const char* why) {
    if (options_.strict) pbd::detail::refuse("mesh", why, '"' + file + '"');
    warnings_.add("link", title, std::string("its mesh is not read: it must be ") + why);
    return collision::Hull{};
  };
  if (!scale.allFinite()) pbd::detail::refuse("mesh scale", "finite");
  const std::string kind = lower_extension(fs::path(file));
  if (kind != ".stl" && kind != ".obj") return pass_over("STL or OBJ");
  const fs::path path = path_of(file);
  if (path.empty()) {
    return pass_over(
        "a file that is there, below the folder of its package in "
        "UrdfOptions::packages");
  }
  collision::Hull& out = hulls_[{path, {scale[0], scale[1], scale[2]}}];
  if (out != nullptr) return out;
  std::vector<Vec3> scaled = points(path, kind == ".stl");
  scene_files::require_within(path.string(), limits_.add(&SceneLimits::hull_points, scaled.size()));
  for (Vec3& point : scaled) point = point.cwiseProduct(scale);
  return out = scene_files::nearest_hull(scaled, options_.strict, [&](const std::string& off) {
           warnings_.add("link", title + ' ' + off, scene_files::kNearestHull);
         });
}

}  // namespace tandem::urdf_files
