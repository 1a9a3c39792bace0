// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// The frame is between the feet: x forward, y left, z up.
struct TANDEM_API RagdollDef {
  Pose pose = {};
  double height = 1.75;  ///< m, > 0
  double mass = 70.0;    ///< kg, > 0, in total
  double damping = 2.0;  ///< N m s/rad, >= 0, of each joint: lower is limper
  collision::Material material = {};
  /// Group 0: a new group, so that limbs pass through each other.
  collision::Filter filter = {};
  std::uint64_t user_data = 0;
};

/// A limp human: eleven bodies and ten joints with human limits.
///
///     Ragdoll victim(scene, {.pose = hero_feet, .mass = 80.0});
///     scene.step(dt);
///
/// Lengths and masses are those of [winter2009] Fig. 4.1 and Table 4.1, as shares of height and
/// mass; feet are part of shins and hands of forearms. It starts upright, arms down.
/// Errors: std::invalid_argument naming field, value and rule; the scene is then unchanged.
/// @par Thread safety  As its scene.
class TANDEM_API Ragdoll {
 public:
  enum Part : std::size_t {
    Pelvis,
    Chest,
    Head,
    LeftUpperArm,
    LeftForearm,
    RightUpperArm,
    RightForearm,
    LeftThigh,
    LeftShin,
    RightThigh,
    RightShin,
  };
  static constexpr std::size_t kParts = 11;

  /// Adds bodies and joints to the scene; they stay there until they are removed.
  Ragdoll(Scene& scene, const RagdollDef& def);

  const std::array<BodyId, kParts>& bodies() const { return bodies_; }
  BodyId body(Part part) const { return bodies_[part]; }
  /// The joint that holds the part: spine, neck, shoulder, elbow, hip or knee; none for the pelvis.
  pbd::JointId joint(Part part) const { return joints_[part]; }

 private:
  std::array<BodyId, kParts> bodies_;
  std::array<pbd::JointId, kParts> joints_;
};

}  // namespace tandem
