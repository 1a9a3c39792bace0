// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "tandem/pbd/types.h"

namespace tandem::scene_files {

/// Mass properties of parts that are fixed to each other as one body.
class RigidParts {
 public:
  /// Adds a part; all in one frame. @param inertia  kg m^2, about `com`
  void add(double mass, const pbd::Vec3& com, const pbd::Mat3& inertia) {
    parts_.push_back({mass, com, inertia});
    mass_ += mass;
  }
  double mass() const { return mass_; }  ///< kg
  /// m; @pre mass() > 0
  pbd::Vec3 com() const {
    if (parts_.size() == 1) return parts_[0].com;
    pbd::Vec3 sum = pbd::Vec3::Zero();
    for (const Part& part : parts_) sum += part.mass * part.com;
    return sum / mass_;
  }
  /// kg m^2, about com(); @pre mass() > 0
  pbd::Mat3 inertia() const {
    const pbd::Vec3 middle = com();
    pbd::Mat3 sum = pbd::Mat3::Zero();
    for (const Part& part : parts_) {
      const pbd::Vec3 arm = part.com - middle;
      sum += part.inertia +
             part.mass * (arm.squaredNorm() * pbd::Mat3::Identity() - arm * arm.transpose());
    }
    return sum;
  }

 private:
  struct Part {
    double mass;
    pbd::Vec3 com;
    pbd::Mat3 inertia;
  };
  std::vector<Part> parts_;
  double mass_ = 0.0;
};

struct MendedInertia {
  pbd::Mat3 inertia;  ///< kg m^2
  double change;      ///< largest change of a moment, as a share of the largest one
};

/// The nearest valid inertia. A body's moments are sums of two of three second moments, the
/// integrals of x^2, y^2 and z^2 along the principal axes: negative ones become 0. If that leaves
/// no moment about an axis, each second moment becomes at least that of a ball.
/// @param ball  kg m^2, > 0: the ball's moment
/// @return nothing if a moment is further below 0 than half the largest one, or half the ball's:
///   that is neither rounding nor an omitted shape
inline std::optional<MendedInertia> mend_inertia(const pbd::Mat3& inertia, double ball) {
  const Eigen::SelfAdjointEigenSolver<pbd::Mat3> eigen(inertia);
  const pbd::Vec3 given = eigen.eigenvalues();  // ascending
  const double size = std::max(given[2], ball);
  if (!(given[0] >= -0.5 * size)) return {};
  pbd::Vec3 second = pbd::Vec3::Constant(0.5 * given.sum()) - given;
  const auto moments = [&] { return pbd::Vec3(pbd::Vec3::Constant(second.sum()) - second); };
  second = second.cwiseMax(0.0);
  // Smallest share that World accepts, as it needs an inverse.
  constexpr double kThin = 1e-9;
  if (!(moments().minCoeff() > kThin * size)) second = second.cwiseMax(0.5 * ball);
  const pbd::Vec3 mended = moments();
  const pbd::Mat3& axes = eigen.eigenvectors();
  return MendedInertia{axes * mended.asDiagonal() * axes.transpose(),
                       (mended - given).cwiseAbs().maxCoeff() / mended.maxCoeff()};
}

}  // namespace tandem::scene_files
