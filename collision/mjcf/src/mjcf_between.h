// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "mjcf_joints.h"

namespace tandem::mjcf {

/// Bodies between two joints of a body, massless in MuJoCo, light here. Mass on the axis of a hinge
/// moves the same whichever of its two bodies it belongs to: the body loses what is on the axis,
/// and the motion does not change. Only inertia about the axis is added, and with three hinges that
/// of the first body in between.
/// @param joints  of joint_ranges(), two or more
/// @param body    all in its frame, by BodyDef::origin; loses as much as possible of what the
///   others get
/// @return        a body before each range but the first, in order, with poses in the body's frame
std::vector<pbd::BodyDef> bodies_between(const mjModel& model,
                                         const std::vector<JointRange>& joints, pbd::BodyDef& body);

}  // namespace tandem::mjcf
