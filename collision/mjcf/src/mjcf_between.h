// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "mjcf_joints.h"

namespace tandem::mjcf {

/// What stands between two joints of a body. In MuJoCo that weighs nothing, here a little. Mass on
/// the axis of a hinge goes the same way whichever of its two bodies it belongs to: the body loses
/// what lies on the axis, and nothing moves otherwise. Inertia about the axis is all that is more
/// than there, and of three hinges that of the first body in between.
/// @param joints  of joint_ranges(), two or more
/// @param body    all in its frame, by BodyDef::origin; loses what it can of what the others get
/// @return        before each range but the first, in their order, with poses in the body's frame
std::vector<pbd::BodyDef> bodies_between(const mjModel& model,
                                         const std::vector<JointRange>& joints, pbd::BodyDef& body);

}  // namespace tandem::mjcf
