// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "tandem/pbd/export.h"
#include "tandem/scene_files.h"

namespace tandem {

struct TANDEM_API MjcfOptions {
  SceneOptions scene = {};  ///< gravity is the model's
  SceneLimits limits = {};
  std::string keyframe = {};  ///< keyframe of the model where joints start; empty: qpos0
  /// Whether meshes with hulls that are flat or have more than 128 corners, and elements that
  /// MuJoCo's schema does not know, are errors. Otherwise the nearest hull is used and unknown
  /// elements are left out, with warnings.
  bool strict = false;
  /// Whether equality/joint couples joints (pbd::JointCoupling). No scene file has couplings:
  /// write_scene() refuses such a scene. Otherwise they move freely, with a warning.
  bool couple = true;
};

/// Reads an MJCF model, compiled by Debian's MuJoCo: bodies at qpos0, at a keyframe, or as near to
/// it as ranges allow, with the masses that MuJoCo finds; geoms; joints with ranges, springs,
/// damping, dry friction and actuators with affine force (SceneFile::set_control()); gravity.
/// Bodies without joints become parts of the body that they are fixed to; SceneFile::pose() gives
/// the frame of any body. Mocap bodies are kinematic. Geoms meet by their contype and conaffinity
/// as in MuJoCo, but bodies of one tree do not meet each other. If no single joint can replace the
/// joints of a body, such as the hinges of a hip, light unnamed bodies are put between them.
/// Elements that are not read give warnings, see docs/scene_files.md. MuJoCo reads included files
/// from anywhere: parse untrusted models from text, which has no files beside it.
/// @throws SceneFileError
/// @par Thread safety  One call at a time in a process, a limit of MuJoCo.
TANDEM_API SceneFile load_mjcf(const std::filesystem::path& path, const MjcfOptions& options = {});
TANDEM_API SceneFile parse_mjcf(std::string_view text, const MjcfOptions& options = {},
                                std::string_view name = "mjcf");

}  // namespace tandem
