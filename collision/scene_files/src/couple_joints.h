// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/joint_coupling.h"
#include "tandem/scene.h"

namespace tandem::scene_files {

/// Holds c_two - ratio c_one = offset for hinges and sliders.
/// @return false, without effect, if one of them is neither, or both hold one body
inline bool couple_joints(Scene& scene, pbd::JointId one, pbd::JointId two, double ratio,
                          double offset) {
  const pbd::JointBlock& joints = scene.joints();
  if (!joints.contains(one) || !joints.contains(two)) return false;
  try {
    const auto def = pbd::JointCoupling::between(joints, one, two, ratio, offset);
    pbd::World& world = scene.world();
    for (const auto& block : world.blocks()) {
      if (auto* known = dynamic_cast<pbd::JointCouplingBlock*>(block.get())) {
        known->add(world, def);
        return true;
      }
    }
    pbd::JointCoupling::check(world, def);
    world.add_block<pbd::JointCouplingBlock>().add(world, def);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

}  // namespace tandem::scene_files
