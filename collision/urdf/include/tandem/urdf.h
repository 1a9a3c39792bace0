// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/scene_files.h"

namespace tandem {

struct TANDEM_API UrdfOptions {
  SceneOptions scene = {};
  Pose base = {};            ///< of the root link's frame
  bool fixed_base = true;    ///< the root link is static
  double tip_mass = 1e-3;    ///< kg, > 0, of links that move by themselves and have none
  double tip_radius = 0.01;  ///< m, > 0, of the ball whose inertia those have
  /// Masses of 0, inertias that no body can have, meshes that are not read and those whose hull is
  /// flat or has more than 128 corners are errors. Else they are mended or left out, and told.
  bool strict = false;
  /// m or rad, by joint; all others start at 0. What is outside a joint's limits starts at the
  /// nearest place within, and is told.
  std::map<std::string, double, std::less<>> start = {};
  /// Folders by package: meshes named "package://NAME/..." are read from folder NAME or below,
  /// those of relative names from the folder of "". Nothing else is opened.
  std::map<std::string, std::filesystem::path, std::less<>> packages = {};
  /// Whether joints that mimic another one are coupled with it (pbd::JointCoupling), which no scene
  /// file has: write_scene() refuses such a scene. Else they move freely, and are told.
  bool mimic = true;
  SceneLimits limits = {};
};

/// A robot by URDF, read with Debian's urdfdom: links as bodies, at all joints' zero or as
/// near to it as limits let them, joints with limits, damping, dry friction and effort. Links on
/// fixed joints are parts of the body that they are fixed to, with their inertia; SceneFile::pose()
/// is that of any link's frame. Links of one robot do not meet each other. Meshes of STL and
/// OBJ in UrdfOptions::packages collide as their hulls, of at most 128 corners. Told as warnings:
/// other meshes, transmissions and what else urdfdom does not know, masses of 0 and
/// inertias that no body can have.
/// @throws SceneFileError
TANDEM_API SceneFile load_urdf(const std::filesystem::path& path, const UrdfOptions& options = {});
TANDEM_API SceneFile parse_urdf(std::string_view text, const UrdfOptions& options = {},
                                std::string_view name = "urdf");

}  // namespace tandem
