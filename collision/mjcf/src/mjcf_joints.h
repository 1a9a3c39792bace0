// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "mjcf_model.h"

namespace tandem::mjcf {

/// A hinge or slide of the model, in a joint of Tandem.
struct Coordinate {
  int joint;       ///< in the model
  int coordinate;  ///< as those of pbd::JointState::position
  double sign;     ///< -1: it runs the other way
};
struct BodyJoint {
  int body;  ///< in the model
  pbd::SixDofJointDef def;
  std::vector<Coordinate> coordinates;  ///< those that are no balls
};

/// The joints of a body that has some, none of them free, as one. MuJoCo takes them in their order,
/// each in the frame that those before it have moved.
/// @param frame  of the body, world, at qpos0
/// @throws SceneFileError  where no sixDof joint moves so
BodyJoint joint_of(Model& model, int body, const pbd::World& world, BodyId parent, BodyId child,
                   const Pose& frame);

}  // namespace tandem::mjcf
