// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without joints do not link it.
#include "add_whole.h"
#include "tandem/scene.h"

namespace tandem {

pbd::JointBlock& Scene::joints() {
  // Searched each time: it can be removed from the world, or exist before.
  for (const auto& block : world().blocks()) {
    if (auto* const joints = dynamic_cast<pbd::JointBlock*>(block.get())) return *joints;
  }
  return world().add_block<pbd::JointBlock>();
}

pbd::JointId Scene::add_joint(const pbd::SixDofJointDef& def) {
  pbd::JointId id;
  detail::add_whole(*this, {}, [&] { id = joints().add(world(), def); });
  return id;
}

}  // namespace tandem
