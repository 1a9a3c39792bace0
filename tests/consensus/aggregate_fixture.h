// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "consensus/random.h"
#include "tandem/consensus/aggregate.h"

namespace tandem::consensus::testing {

using pbd::Quat;
using pbd::Vec3;

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;

inline Quat turned(const Vec3& rotation) {
  const double angle = rotation.norm();
  return angle == 0.0 ? Quat(1.0, 0.0, 0.0, 0.0) : Quat(Eigen::AngleAxisd(angle, rotation / angle));
}

inline double angle_between(const Quat& a, const Quat& b) {
  const Quat d = a * b.conjugate();
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

/// Image of the local orientation under the target.
inline Quat applied(const pbd::Pose& local, const pbd::PoseTarget& target) {
  return turned(target.share * target.rotation_error) * local.orientation;
}

/// Dominant eigenvector of sum w q q^T by Eigen's dense solver, in world quaternions: shares no
/// code and no frame with what is tested.
struct DenseMean {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  void add(const Quat& q, double w) {
    const Eigen::Vector4d c = q.coeffs();
    sum += w * c * c.transpose();
  }
  Quat result() const {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
    const Eigen::Vector4d c = solver.eigenvectors().col(3);
    return Quat(c[3], c[0], c[1], c[2]);
  }
};

inline pbd::Pose some_pose(Dice& dice) {
  pbd::Pose pose;
  pose.position = dice.vec3(10.0);
  pose.orientation = dice.rotation(3.1);
  return pose;
}

/// Estimates around a pose, within `spread` of each other; quaternion signs at random.
inline std::vector<PeerEstimate> around(Dice& dice, const pbd::Pose& local, std::size_t count,
                                        double spread, double max_share) {
  std::vector<PeerEstimate> estimates(count);
  for (std::size_t i = 0; i < count; ++i) {
    PeerEstimate& e = estimates[i];
    e.peer = 100 + 7 * i;
    e.pose.position = local.position + dice.vec3(1.0);
    e.pose.orientation = dice.rotation(0.5 * spread) * local.orientation;
    if (dice.below(2) == 0) e.pose.orientation.coeffs() *= -1.0;
    e.twist.linear = dice.vec3(5.0);
    e.twist.angular = dice.vec3(5.0);
    e.share = dice.uniform(1e-3, max_share);
  }
  return estimates;
}

}  // namespace tandem::consensus::testing
