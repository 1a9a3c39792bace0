// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "convert.h"
#include "file_impl.h"
#include "guard.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

std::filesystem::path path_of(const char* text, const char* name) {
  return {reinterpret_cast<const char8_t*>(&required(text, name))};
}

/// Only names the file if its folders would leave no room for the fault in a tandem_error.
SceneFile loaded(const std::filesystem::path& path, const SceneOptions& options) {
  try {
    return load_scene(path, options);
  } catch (const SceneFileError& error) {
    const std::string_view text = error.what();
    const std::string whole = path.string();
    if (!text.starts_with(whole)) throw;
    throw SceneFileError(path.filename().string() + std::string(text.substr(whole.size())));
  }
}

SceneFile parsed(tandem_scene_format format, std::string_view text, const char* folder,
                 const SceneOptions& options) {
  switch (format) {
    case TANDEM_SCENE_JSON:
      return parse_scene(text, options);
    case TANDEM_SCENE_GLTF:
      return parse_gltf(text, path_of(folder, "folder"), options);
  }
  refuse_unlisted("format", format, "tandem_scene_format");
}

tandem_world* world_of(SceneFile read, const tandem_world_def& def, tandem_scene_file** file) {
  const auto kept = std::make_shared<SceneFile>(std::move(read));
  auto world =
      std::make_unique<tandem_world>(std::shared_ptr<Scene>(kept, &kept->scene), def.events != 0);
  if (file != nullptr) *file = new tandem_scene_file{.file = kept};
  return world.release();
}

std::string_view text_of(const char* text, size_t size) { return {&required(text, "text"), size}; }

/// Result of `find` for a name.
template <class Find>
auto named(const char* name, Find&& find) {
  const auto found = find(&required(name, "name"));
  if (found == decltype(found){}) pbd::detail::refuse("name", "one of the file's", name);
  return found;
}

}  // namespace

tandem_world* tandem_scene_load(const char* path, const tandem_world_def* def,
                                tandem_scene_file** file, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_world_def& d = required(def, "def");
    return world_of(loaded(path_of(path, "path"), options_of(d)), d, file);
  });
}

tandem_world* tandem_scene_parse(tandem_scene_format format, const char* text, size_t size,
                                 const char* folder, const tandem_world_def* def,
                                 tandem_scene_file** file, tandem_error* error) {
  return made_by(error, [&] {
    const tandem_world_def& d = required(def, "def");
    return world_of(parsed(format, text_of(text, size), folder, options_of(d)), d, file);
  });
}

void tandem_scene_file_destroy(tandem_scene_file* file) { delete file; }

size_t tandem_scene_file_bodies(const tandem_scene_file* file, tandem_named_body* bodies,
                                size_t capacity) {
  if (file == nullptr) return 0;
  const auto& all = file->file->bodies;
  for (size_t i = 0; i < all.size() && i < capacity && bodies != nullptr; ++i) {
    bodies[i] = {.name = all[i].name.c_str(), .body = to_c(all[i].body)};
  }
  return all.size();
}

size_t tandem_scene_file_joints(const tandem_scene_file* file, tandem_named_joint* joints,
                                size_t capacity) {
  if (file == nullptr) return 0;
  const auto& all = file->file->joints;
  for (size_t i = 0; i < all.size() && i < capacity && joints != nullptr; ++i) {
    joints[i] = {.name = all[i].name.c_str(), .joint = to_c(all[i].joint)};
  }
  return all.size();
}

size_t tandem_scene_file_warnings(const tandem_scene_file* file, const char** warnings,
                                  size_t capacity) {
  if (file == nullptr) return 0;
  const auto& all = file->file->warnings;
  for (size_t i = 0; i < all.size() && i < capacity && warnings != nullptr; ++i) {
    warnings[i] = all[i].c_str();
  }
  return all.size();
}

tandem_result tandem_scene_file_find_body(const tandem_scene_file* file, const char* name,
                                          tandem_body* body, tandem_error* error) {
  return guarded(error, [&] {
    const SceneFile& f = *required(file, "file").file;
    tandem_body& out = required(body, "body");
    out = to_c(named(name, [&](const char* text) { return f.find(text); }));
  });
}

tandem_result tandem_scene_file_find_joint(const tandem_scene_file* file, const char* name,
                                           tandem_joint* joint, tandem_error* error) {
  return guarded(error, [&] {
    const SceneFile& f = *required(file, "file").file;
    tandem_joint& out = required(joint, "joint");
    out = to_c(named(name, [&](const char* text) { return f.find_joint(text); }));
  });
}

tandem_result tandem_scene_file_pose(const tandem_scene_file* file, const char* name,
                                     tandem_pose* pose, tandem_error* error) {
  return guarded(error, [&] {
    const SceneFile& f = *required(file, "file").file;
    tandem_pose& out = required(pose, "pose");
    out = to_c(f.pose(&required(name, "name")));
  });
}

tandem_result tandem_scene_add_body(tandem_world* world, const char* text, size_t size,
                                    tandem_body* body, tandem_error* error) {
  return guarded(error, [&] {
    tandem_world& w = required(world, "world");
    tandem_body& out = required(body, "body");
    out = to_c(add_body(*w.scene, text_of(text, size)).body);
  });
}
