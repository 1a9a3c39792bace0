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
/// Joints of the model that follow each other, from `first` to before `end`.
struct JointRange {
  int first, end;
};
/// Some joints of a body, as one.
struct BodyJoint {
  JointRange range;
  BodyId child;
  pbd::SixDofJointDef def;
  std::vector<Coordinate> coordinates;  ///< those that are no balls
};

/// A body's joints, none of them free, as few joints of Tandem in their order: between two of them
/// stands a body. A joint is slides at right angles to each other and a hinge or a ball, either
/// before all slides or behind them, with the hinge's axis along a slide or at right angles to all.
std::vector<JointRange> joint_ranges(const mjModel& model, int body);

/// MuJoCo takes a body's joints in their order, each in the frame that those before it have moved.
/// @param range  of joint_ranges()
/// @param frame  of the body, world, at qpos0
BodyJoint joint_of(Model& model, JointRange range, const pbd::World& world, BodyId parent,
                   BodyId child, const Pose& frame);

}  // namespace tandem::mjcf
