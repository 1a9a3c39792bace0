// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_actuators.h"

#include <algorithm>
#include <cmath>

#include "actuators.h"

namespace tandem::mjcf {
namespace {

/// Actuators of a hinge or slide of the model.
struct Place {
  std::size_t joint = 0;  ///< index in Tandem
  const Coordinate* coordinate = nullptr;
  scene_files::Pull pull;  ///< sum over its actuators
  int count = 0;           ///< number of actuators
  bool is_driven = false;
};

}  // namespace

std::optional<Actuators::Affine> Actuators::affine(int a) {
  Affine law{};
  const mjModel& m = model_.m;
  const int kind = m.actuator_trntype[a];
  const char* other = nullptr;
  if (kind != mjTRN_JOINT && kind != mjTRN_JOINTINPARENT) {
    other = "it acts on no joint, and is not read";
  } else if (const int type = m.jnt_type[m.actuator_trnid[2 * a]];
             type != mjJNT_HINGE && type != mjJNT_SLIDE) {
    other = "it acts on a ball or a free joint, and is not read";
  } else if (m.actuator_dyntype[a] != mjDYN_NONE || m.actuator_gaintype[a] != mjGAIN_FIXED ||
             (m.actuator_biastype[a] != mjBIAS_NONE && m.actuator_biastype[a] != mjBIAS_AFFINE)) {
    other = "its force is not affine in control, position and speed, and is not read";
  } else {
    law = {.gain = m.actuator_gainprm[mjNGAIN * a]};
    if (m.actuator_biastype[a] == mjBIAS_AFFINE) {
      const mjtNum* bias = m.actuator_biasprm + mjNBIAS * a;
      law.bias = bias[0];
      law.length_gain = bias[1];
      law.speed_gain = bias[2];
    }
    if (law.length_gain > 0.0 || law.speed_gain > 0.0) {
      other = "its stiffness or damping is negative, and it is not read";
    }
  }
  if (other == nullptr) return law;
  model_.warn(mjOBJ_ACTUATOR, a, other);
  return {};
}

/// Converts ranges of control and force: to a range of control if the force depends on that alone,
/// else to the largest force of a servo.
/// @param alone  no other actuator acts on its coordinate
void Actuators::limit(int a, const Affine& law, bool alone, SceneFile::Actuator& out) {
  const mjModel& m = model_.m;
  out.lower = -pbd::kUnlimited;
  out.upper = pbd::kUnlimited;
  if (m.actuator_ctrllimited[a] && !model_.off(mjDSBL_CLAMPCTRL)) {
    out.lower = m.actuator_ctrlrange[2 * a];
    out.upper = m.actuator_ctrlrange[2 * a + 1];
  }
  const double gear = std::abs(m.actuator_gear[6 * a]);
  if (!m.actuator_forcelimited[a] || gear == 0.0) return;
  const mjtNum* range = m.actuator_forcerange + 2 * a;
  if (law.length_gain == 0.0 && law.speed_gain == 0.0 && law.gain != 0.0) {
    const double low = (range[0] - law.bias) / law.gain;
    const double high = (range[1] - law.bias) / law.gain;
    out.lower = std::clamp(std::min(low, high), out.lower, out.upper);
    out.upper = std::clamp(std::max(low, high), out.lower, out.upper);
    return;
  }
  if (!alone || (law.length_gain == 0.0 && law.speed_gain == 0.0)) {
    return model_.warn(mjOBJ_ACTUATOR, a,
                       alone ? "forcerange is not kept: nothing sets its force"
                             : "forcerange is not kept where several act at one joint");
  }
  out.damping = -law.speed_gain * gear * gear;
  out.max_force = gear * std::max(std::abs(range[0]), std::abs(range[1]));
  if (range[0] != -range[1]) {
    model_.warn(mjOBJ_ACTUATOR, a, "the larger bound of forcerange is kept either way");
  }
}

void Actuators::put(std::span<BodyJoint> joints) {
  const mjModel& m = model_.m;
  if (model_.off(mjDSBL_ACTUATION)) return;
  std::vector<Place> places(static_cast<std::size_t>(m.njnt));
  for (std::size_t k = 0; k < joints.size(); ++k) {
    for (const Coordinate& one : joints[k].coordinates) {
      places[static_cast<std::size_t>(one.joint)] = {.joint = k, .coordinate = &one};
    }
  }
  std::vector<std::optional<Affine>> laws;
  for (int a = 0; a < m.nu; ++a) {
    laws.push_back(affine(a));
    if (laws.back()) ++places[static_cast<std::size_t>(m.actuator_trnid[2 * a])].count;
  }
  for (int a = 0; a < m.nu; ++a) {
    if (!laws[static_cast<std::size_t>(a)]) continue;
    const Affine& law = *laws[static_cast<std::size_t>(a)];
    const int j = m.actuator_trnid[2 * a];
    Place& place = places[static_cast<std::size_t>(j)];
    const Coordinate& at = *place.coordinate;
    // MuJoCo's length is gear * qpos; Tandem's coordinate is 0 at qpos0.
    const double gear = m.actuator_gear[6 * a];
    const double back = at.sign * gear;
    SceneFile::Actuator one{
        .name = model_.name(mjOBJ_ACTUATOR, a),
        .coordinate = at.coordinate,
        .gain = back * law.gain,
        .bias = back * (law.bias + law.length_gain * gear * m.qpos0[m.jnt_qposadr[j]]),
        .stiffness = -law.length_gain * gear * gear};
    limit(a, law, place.count == 1, one);
    one.control = std::clamp(controls_ == nullptr ? 0.0 : controls_[a], one.lower, one.upper);
    pbd::JointAxis& axis = scene_files::axis_of(joints[place.joint].def, at.coordinate);
    if (one.max_force < pbd::kUnlimited) {
      model_.guard(mjOBJ_JOINT, j, [&] { axis.motor = scene_files::servo_of(one); });
      driven_.push_back({std::move(one), place.joint});
      continue;
    }
    pbd::JointSpring& spring = axis.spring;
    spring.damping -= law.speed_gain * gear * gear;
    if (!place.is_driven) {
      one.bias += spring.stiffness * spring.rest;
      one.stiffness += spring.stiffness;
      place.is_driven = true;
    }
    place.pull.force += one.gain * one.control + one.bias;
    place.pull.stiffness += one.stiffness;
    driven_.push_back({std::move(one), place.joint});
  }
  for (const Place& place : places) {
    if (!place.is_driven) continue;
    const Coordinate& at = *place.coordinate;
    pbd::JointAxis& axis = scene_files::axis_of(joints[place.joint].def, at.coordinate);
    model_.guard(mjOBJ_JOINT, at.joint, [&] { place.pull.put(axis); });
  }
}

void Actuators::append_to(std::vector<SceneFile::Actuator>& out,
                          std::span<const pbd::JointId> ids) const {
  for (const Driven& one : driven_) {
    out.push_back(one.actuator);
    out.back().joint = ids[one.joint];
  }
}

}  // namespace tandem::mjcf
