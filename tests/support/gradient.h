// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <vector>

#include "support/oracles.h"
#include "tandem/pbd/corrections.h"

/// Numerical check of a row's Jacobian: what one projection of a rigid row must do, from nothing
/// but the constraint function C(poses) that the test writes down again.
namespace tandem::testing {

using ConstraintFunction = std::function<Eigen::VectorXd(const std::vector<Pose>&)>;

/// dC/d(dx_0, dtheta_0, dx_1, ...) by central differences; rotations are world rotation vectors.
inline Eigen::MatrixXd numeric_jacobian(const ConstraintFunction& c, std::vector<Pose> poses) {
  constexpr double kStep = 1e-6;
  const auto columns = static_cast<Eigen::Index>(6 * poses.size());
  Eigen::MatrixXd jacobian(c(poses).size(), columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    Pose& pose = poses[static_cast<std::size_t>(k / 6)];
    const Pose kept = pose;
    const auto moved = [&](double step) {
      if (k % 6 < 3) {
        pose.position[k % 6] += step;
      } else {
        Vec3 axis = Vec3::Zero();
        axis[k % 3] = step;
        pose.orientation = turn(axis) * pose.orientation;
      }
      const Eigen::VectorXd value = c(poses);
      pose = kept;
      return value;
    };
    jacobian.col(k) = (moved(kStep) - moved(-kStep)) / (2.0 * kStep);
  }
  return jacobian;
}

/// The correction (dx_0, dtheta_0, dx_1, ...) of one exact projection of C = 0:
/// -M^-1 J^T (J M^-1 J^T)^-1 C.
inline Eigen::VectorXd expected_projection(const ConstraintFunction& c,
                                           const std::vector<pbd::SolverBody>& bodies) {
  std::vector<Pose> poses;
  for (const pbd::SolverBody& body : bodies) poses.push_back({body.x, body.q});
  const Eigen::MatrixXd j = numeric_jacobian(c, poses);
  Eigen::MatrixXd inverse_mass = Eigen::MatrixXd::Zero(j.cols(), j.cols());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    inverse_mass.block<3, 3>(at, at) = Mat3::Identity() * bodies[i].inv_mass;
    inverse_mass.block<3, 3>(at + 3, at + 3) = bodies[i].inv_inertia_w;
  }
  const Eigen::MatrixXd spread = j * inverse_mass * j.transpose();
  return -inverse_mass * j.transpose() * Eigen::VectorXd(spread.fullPivLu().solve(c(poses)));
}

/// The sums of corrections that a projection left in the bodies, in the same order.
inline Eigen::VectorXd corrections_of(const std::vector<pbd::SolverBody>& bodies) {
  Eigen::VectorXd sum(static_cast<Eigen::Index>(6 * bodies.size()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    sum.segment<3>(at) = bodies[i].dx;
    sum.segment<3>(at + 3) = bodies[i].dtheta;
  }
  return sum;
}

/// A body as the pass sees it.
inline pbd::SolverBody solver_body(const Pose& pose, double mass, const Mat3& inertia) {
  pbd::SolverBody body;
  body.x = pose.position;
  body.q = pose.orientation;
  body.inv_mass = 1.0 / mass;
  const Mat3 r = pose.orientation.toRotationMatrix();
  body.inv_inertia_w = r * inertia.inverse() * r.transpose();
  return body;
}

}  // namespace tandem::testing
