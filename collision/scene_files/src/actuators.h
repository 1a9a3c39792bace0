// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/validate.h"

namespace tandem::scene_files {

/// Of all that pulls at a coordinate: force - stiffness * coordinate.
struct Pull {
  double force = 0.0;      ///< N or N m, where the coordinate is 0
  double stiffness = 0.0;  ///< N/m or N m/rad, >= 0

  /// As a spring; what would have its rest far away, or nowhere, as a motor that never gets to its
  /// speed beside one. With rests of 1e9 m a tree of eight bodies came 4e9 m far.
  /// @throws std::invalid_argument  where it is not finite
  void put(pbd::JointAxis& axis) const {
    constexpr double kFar = 1e3;   // m or rad
    constexpr double kFast = 1e3;  // m/s or rad/s
    if (!std::isfinite(force) || !std::isfinite(stiffness)) {
      pbd::detail::refuse("actuator: force", "finite", force);
    }
    const bool pushes = std::abs(force) > kFar * stiffness;
    axis.spring.stiffness = stiffness;
    axis.spring.rest = pushes || stiffness == 0.0 ? 0.0 : force / stiffness;
    axis.motor = {};
    if (pushes) {
      axis.motor = {.mode = pbd::MotorMode::Velocity,
                    .target = std::copysign(kFast, force),
                    .max_force = std::abs(force)};
    }
  }
};

/// @param coordinate  as those of pbd::JointState::position
inline pbd::JointAxis& axis_of(pbd::SixDofJointDef& def, int coordinate) {
  auto& axes = coordinate < 3 ? def.linear : def.angular;
  return axes[static_cast<std::size_t>(coordinate % 3)];
}

}  // namespace tandem::scene_files
