// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "tandem/c/tandem.h"
#include "tandem/scene_files.h"

struct tandem_scene_file {
  std::shared_ptr<tandem::SceneFile> file;  ///< owns the world's scene
};
