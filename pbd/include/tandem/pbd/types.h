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

/// q * v with the same bits. Eigen's own writes its cross product number by number and reads it in
/// pairs, which stalls store forwarding for longer than all the rest takes.
[[gnu::always_inline]] inline Vec3 rotate(const Quat& q, const Vec3& v) {
  const double x = 2.0 * (q.y() * v.z() - q.z() * v.y());
  const double y = 2.0 * (q.z() * v.x() - q.x() * v.z());
  const double z = 2.0 * (q.x() * v.y() - q.y() * v.x());
  return {v.x() + q.w() * x + (q.y() * z - q.z() * y), v.y() + q.w() * y + (q.z() * x - q.x() * z),
          v.z() + q.w() * z + (q.x() * y - q.y() * x)};
}

/// Position (m) and orientation of the centre-of-mass frame of a body in the world.
struct TANDEM_API Pose {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  /// World position (m) of a point given in the local frame (m).
  Vec3 to_world(const Vec3& point_l) const { return position + rotate(orientation, point_l); }
  /// Local position (m) of a point given in the world frame (m).
  Vec3 to_local(const Vec3& point_w) const {
    return rotate(orientation.conjugate(), point_w - position);
  }
};

/// Linear (m/s) and angular (rad/s) velocity of the centre of mass, both in the world frame.
struct TANDEM_API Twist {
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};

}  // namespace tandem::pbd
