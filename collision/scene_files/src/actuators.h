// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem::scene_files {

/// Sum of the forces on a coordinate: force - stiffness * coordinate.
struct Pull {
  double force = 0.0;      ///< N or N m, at coordinate 0
  double stiffness = 0.0;  ///< N/m or N m/rad, >= 0

  /// As a spring. If its rest would be far away or nowhere, the constant force becomes a servo that
  /// is at its bound up to kFast. With rests of 1e9 m a tree of eight bodies went 4e9 m far.
  /// @throws std::invalid_argument  if it is not finite
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
                    .target = std::copysign(2.0 * kFast, force),
                    .max_force = std::abs(force),
                    .damping = std::abs(force) / kFast};
    }
  }
};

/// The servo of an actuator with bounded force, at its control.
/// @throws std::invalid_argument  if its force is not finite
inline pbd::JointMotor servo_of(const SceneFile::Actuator& actuator) {
  const double force = actuator.gain * actuator.control + actuator.bias;
  const bool to_position = actuator.stiffness > 0.0;
  const double target = force / (to_position ? actuator.stiffness : actuator.damping);
  if (!std::isfinite(target)) pbd::detail::refuse("actuator: force", "finite", force);
  return {.mode = to_position ? pbd::MotorMode::Position : pbd::MotorMode::Velocity,
          .target = target,
          .max_force = actuator.max_force,
          .stiffness = actuator.stiffness,
          .damping = actuator.damping};
}

/// @param coordinate  index as in pbd::JointState::position
inline pbd::JointAxis& axis_of(pbd::SixDofJointDef& def, int coordinate) {
  auto& axes = coordinate < 3 ? def.linear : def.angular;
  return axes[static_cast<std::size_t>(coordinate % 3)];
}

}  // namespace tandem::scene_files
