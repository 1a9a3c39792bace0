// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "actuators.h"

#include <algorithm>

#include "tandem/pbd/validate.h"
#include "tandem/scene_files.h"

namespace tandem {

void SceneFile::set_control(std::string_view actuator, double control) {
  const auto named = [&](const Actuator& one) { return one.name == actuator; };
  const auto at = std::find_if(actuators.begin(), actuators.end(), named);
  if (at == actuators.end()) {
    pbd::detail::refuse("SceneFile::set_control: actuator", "the name of one of the file's",
                        '"' + std::string(actuator) + '"');
  }
  set_control(static_cast<std::size_t>(at - actuators.begin()), control);
}

void SceneFile::set_control(std::size_t actuator, double control) {
  if (actuator >= actuators.size()) {
    pbd::detail::refuse("SceneFile::set_control: actuator", "a place in SceneFile::actuators",
                        static_cast<double>(actuator));
  }
  if (!std::isfinite(control)) {
    pbd::detail::refuse("SceneFile::set_control: control", "finite", control);
  }
  Actuator& set = actuators[actuator];
  const double within = std::clamp(control, set.lower, set.upper);
  pbd::SixDofJointDef def = scene.joints().def(set.joint);
  pbd::JointAxis& axis = scene_files::axis_of(def, set.coordinate);
  if (set.max_force < pbd::kUnlimited) {
    Actuator changed = set;
    changed.control = within;
    axis.motor = scene_files::servo_of(changed);
  } else {
    scene_files::Pull pull;
    for (const Actuator& one : actuators) {
      if (one.joint != set.joint || one.coordinate != set.coordinate) continue;
      pull.force += one.gain * (&one == &set ? within : one.control) + one.bias;
      pull.stiffness += one.stiffness;
    }
    pull.put(axis);
  }
  scene.joints().set(scene.world(), set.joint, def);
  set.control = within;
}

}  // namespace tandem
