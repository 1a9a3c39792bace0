// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "mjcf_model.h"

namespace tandem::mjcf {

/// A hinge or slide of the model as a coordinate of a joint in Tandem.
struct Coordinate {
  int joint;       ///< index in the model
  int coordinate;  ///< index as in pbd::JointState::position
  double sign;     ///< -1: it is reversed
};
/// Consecutive joints of the model, from `first` up to, not including, `end`.
struct JointRange {
  int first, end;
};
/// Several joints of a body, as one.
struct BodyJoint {
  JointRange range;
  BodyId child;
  pbd::SixDofJointDef def;
  std::vector<Coordinate> coordinates;  ///< without balls
};

/// Splits a body's joints, none of them free, into as few Tandem joints as possible, in order:
/// between two of them there is an extra body. A joint is slides perpendicular to each other and a
/// hinge or a ball, either before or after all slides, with the hinge's axis along a slide or
/// perpendicular to all.
std::vector<JointRange> joint_ranges(const mjModel& model, int body);

/// MuJoCo applies a body's joints in order, each in the frame moved by those before it.
/// @param range  of joint_ranges()
/// @param frame  of the body, world, at qpos0
BodyJoint joint_of(Model& model, JointRange range, const pbd::World& world, BodyId parent,
                   BodyId child, const Pose& frame);

}  // namespace tandem::mjcf
