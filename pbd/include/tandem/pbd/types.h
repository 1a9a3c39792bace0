// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Unit quaternion, local to world. `DontAlign` keeps its layout the same under every -m flag, so
/// that code built with AVX can link a library built without.
using Quat = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Position (m) and orientation of a body's centre of mass frame in the world.
struct TANDEM_API Pose {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  /// World position (m) of a point given in the local frame (m).
  Vec3 to_world(const Vec3& point_l) const { return position + orientation * point_l; }
  /// Local position (m) of a point given in the world frame (m).
  Vec3 to_local(const Vec3& point_w) const {
    return orientation.conjugate() * (point_w - position);
  }
};

/// Linear (m/s) and angular (rad/s) velocity of the centre of mass, both in the world frame.
struct TANDEM_API Twist {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};

}  // namespace tandem::pbd
