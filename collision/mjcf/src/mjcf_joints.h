// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "mjcf_model.h"

namespace tandem::mjcf {

/// The joints of a body that has some, none of them free, as one. MuJoCo takes them in their order,
/// each in the frame that those before it have moved.
/// @param frame  of the body, world, at qpos0
/// @throws SceneFileError  where no sixDof joint moves so
pbd::SixDofJointDef joint_def(Model& model, int body, const pbd::World& world, BodyId parent,
                              BodyId child, const Pose& frame);

}  // namespace tandem::mjcf
