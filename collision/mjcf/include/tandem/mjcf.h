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
  std::string keyframe = {};  ///< of the model, where joints start; empty: at qpos0
  /// Meshes with hulls of more than 128 corners or flat ones, and what MuJoCo's schema does not
  /// know, are errors. Else the nearest hull is taken, what is not known is left out, and both are
  /// told.
  bool strict = false;
  /// Whether equality/joint couples joints (pbd::JointCoupling), which no scene file has:
  /// write_scene() refuses such a scene. Else they move freely, and are told.
  bool couple = true;
};

/// A model by MJCF, compiled by Debian's MuJoCo: bodies at qpos0, a keyframe, or as near to it as
/// ranges let them, with the masses that MuJoCo finds,
/// geoms, joints with ranges, springs, damping, dry friction and actuators whose force is affine
/// (SceneFile::set_control()), gravity. Bodies without joints are
/// parts of those that they are fixed to; SceneFile::pose() is that of any body's frame. Mocap
/// bodies are kinematic. Geoms meet by their contype and conaffinity as in MuJoCo, but bodies of
/// one tree do not meet each other. Between joints of a body that no single one stands for, as the
/// hinges of a hip, stand light bodies without a name. What is not read is told as warnings, by
/// docs/scene_files.md. MuJoCo reads what the model includes, wherever that is: of
/// models of strangers, parse text, which has no files beside it.
/// @throws SceneFileError
/// @par Thread safety  One call at a time in a process, as MuJoCo has it.
TANDEM_API SceneFile load_mjcf(const std::filesystem::path& path, const MjcfOptions& options = {});
TANDEM_API SceneFile parse_mjcf(std::string_view text, const MjcfOptions& options = {},
                                std::string_view name = "mjcf");

}  // namespace tandem
