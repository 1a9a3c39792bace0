// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/scene_files.h"

namespace tandem {

struct TANDEM_API UrdfOptions {
  SceneOptions scene;
  Pose base;                 ///< of the root link's frame
  bool fixed_base = true;    ///< the root link is static
  double tip_mass = 1e-3;    ///< kg, > 0, of links that say none
  double tip_radius = 0.01;  ///< m, > 0, of the ball whose inertia those have
  SceneLimits limits;
};

/// A robot by URDF, read with Debian's urdfdom: links as bodies, at all joints' zero, joints with
/// limits, damping and effort. Scene::pose() is that of a link's frame. Links of one robot do not
/// meet each other. Told as warnings: meshes, friction of joints, mimic joints, velocity limits,
/// transmissions and what else urdfdom does not know.
/// @throws SceneFileError
TANDEM_API SceneFile load_urdf(const std::filesystem::path& path, const UrdfOptions& options = {});
TANDEM_API SceneFile parse_urdf(std::string_view text, const UrdfOptions& options = {},
                                std::string_view name = "urdf");

}  // namespace tandem
