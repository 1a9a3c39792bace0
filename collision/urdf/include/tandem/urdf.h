// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
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
  double tip_mass = 1e-3;    ///< kg, > 0, of moving links without mass
  double tip_radius = 0.01;  ///< m, > 0, of the ball that gives their inertia
  /// Errors: masses of 0, inertias that no body can have, meshes that are not read, and meshes
  /// whose hull is flat or has more than 128 corners. Otherwise these are repaired or left out,
  /// with a warning.
  bool strict = false;
  /// m or rad, by joint; all others start at 0. A value outside a joint's limits is moved to the
  /// nearest one within, with a warning.
  std::map<std::string, double, std::less<>> start = {};
  /// Folders by package: meshes named "package://NAME/..." are read from folder NAME or below,
  /// those with relative names from the folder of "". Nothing else is opened.
  std::map<std::string, std::filesystem::path, std::less<>> packages = {};
  /// Whether joints that mimic another one are coupled to it (pbd::JointCoupling). No scene file
  /// has couplings: write_scene() refuses such a scene. Otherwise they move freely, with a warning.
  bool mimic = true;
  SceneLimits limits = {.hull_points = std::size_t{1} << 20};  ///< meshes of hands have 1e4 each
};

/// Reads a robot from URDF with Debian's urdfdom. Links become bodies, at zero of all joints or as
/// near to it as limits allow; joints have limits, damping, dry friction and effort. Links on fixed
/// joints become parts of the body that they are fixed to, with their inertia; SceneFile::pose()
/// gives the frame of any link. Links of one robot do not meet each other. STL and OBJ meshes in
/// UrdfOptions::packages collide as their hulls, of at most 128 corners. Warnings: other meshes,
/// transmissions and elements that urdfdom does not know, masses of 0 and inertias that no body can
/// have.
/// @throws SceneFileError
TANDEM_API SceneFile load_urdf(const std::filesystem::path& path, const UrdfOptions& options = {});
TANDEM_API SceneFile parse_urdf(std::string_view text, const UrdfOptions& options = {},
                                std::string_view name = "urdf");

}  // namespace tandem
