// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mjcf_joints.h"

namespace tandem::mjcf {

/// The actuators of hinges and slides whose force is affine in control, length and speed. They
/// become springs and dampers of the coordinate with the same force. Others give warnings.
class Actuators {
 public:
  /// @param controls  of the model's actuators, or nullptr: 0
  Actuators(Model& model, const mjtNum* controls) : model_(model), controls_(controls) {}

  /// Call before the joints are added.
  void put(std::span<BodyJoint> joints);
  /// @param ids  of the joints, in the same order
  void append_to(std::vector<SceneFile::Actuator>& out, std::span<const pbd::JointId> ids) const;

 private:
  struct Driven {
    SceneFile::Actuator actuator;
    std::size_t joint;  ///< index among those passed to put()
  };
  /// F = gain control + bias + length_gain length + speed_gain speed, all in the actuator's units.
  struct Affine {
    double gain, bias, length_gain, speed_gain;
  };
  std::optional<Affine> affine(int actuator);
  void limit(int actuator, const Affine& law, bool alone, SceneFile::Actuator& out);

  Model& model_;
  const mjtNum* controls_;
  std::vector<Driven> driven_;
};

}  // namespace tandem::mjcf
