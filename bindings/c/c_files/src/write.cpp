// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstring>
#include <string>

#include "file_impl.h"
#include "guard.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

std::string written(const tandem_world& world, const tandem_scene_file* file) {
  if (file == nullptr) return write_scene(*world.scene);
  const SceneFile& names = *file->file;
  if (&names.scene != world.scene.get()) {
    pbd::detail::refuse("file", "that of the world");
  }
  return write_scene(*world.scene, names.bodies, names.joints);
}

}  // namespace

tandem_result tandem_scene_write(const tandem_world* world, const tandem_scene_file* file,
                                 char* buffer, size_t* size, tandem_error* error) {
  bool fits = true;
  const tandem_result result = guarded(error, [&] {
    size_t& room = required(size, "size");
    const std::string text = written(required(world, "world"), file);
    fits = buffer != nullptr && text.size() < room;
    if (fits) std::memcpy(buffer, text.c_str(), text.size() + 1);
    room = text.size() + 1;
  });
  if (result != TANDEM_OK || fits) return result;
  return c::report(error, TANDEM_TOO_SMALL, "buffer: must hold as many bytes as size says now");
}
