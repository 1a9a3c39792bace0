// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/scene_files.h"

namespace tandem {

/// A model by MJCF, compiled by Debian's MuJoCo: bodies at qpos0 with the masses that MuJoCo finds,
/// geoms, joints with ranges, springs and damping, gravity. Scene::pose() is that of a body's
/// frame. Bodies of one tree do not meet each other. A body may have one joint, or slides at right
/// angles to each other and a hinge; others are refused. Told as warnings: ellipsoids, height
/// fields, actuators, tendons, equalities, sensors, frictionloss, armature and filters that are
/// not symmetric. MuJoCo reads what the model includes, wherever that is: of models of strangers,
/// parse text, which has no files beside it.
/// @throws SceneFileError
/// @par Thread safety  One call at a time in a process, as MuJoCo has it.
TANDEM_API SceneFile load_mjcf(const std::filesystem::path& path, const SceneOptions& options = {},
                               const SceneLimits& limits = {});
TANDEM_API SceneFile parse_mjcf(std::string_view text, const SceneOptions& options = {},
                                std::string_view name = "mjcf", const SceneLimits& limits = {});

}  // namespace tandem
