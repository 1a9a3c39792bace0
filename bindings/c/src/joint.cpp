// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convert.h"
#include "guard.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

pbd::MotorMode mode_of(tandem_motor_mode mode) {
  switch (mode) {
    case TANDEM_MOTOR_OFF:
      return pbd::MotorMode::Off;
    case TANDEM_MOTOR_VELOCITY:
      return pbd::MotorMode::Velocity;
    case TANDEM_MOTOR_POSITION:
      return pbd::MotorMode::Position;
  }
  refuse_unlisted("motor", mode, "tandem_motor_mode");
}

pbd::JointMotor motor_of(tandem_motor_mode mode, double target, double max_force) {
  return {.mode = mode_of(mode), .target = target, .max_force = max_force};
}

pbd::JointAxis axis_of(const tandem_joint_def& def) {
  pbd::JointAxis axis;
  if (def.limited != 0) {
    axis.freedom = pbd::Freedom::Limited;
    axis.lower = def.lower;
    axis.upper = def.upper;
  }
  axis.motor = motor_of(def.motor, def.motor_target, def.motor_max_force);
  return axis;
}

template <class Mount>
pbd::SixDofJointDef mounted(Mount mount, const tandem_joint_def& def) {
  mount.compliance = def.compliance;
  mount.break_force = def.break_force;
  mount.break_torque = def.break_torque;
  return mount;
}

pbd::SixDofJointDef joint_of(const pbd::World& world, const tandem_joint_def& def) {
  const pbd::BodyId a = from_c(def.a);
  const pbd::BodyId b = from_c(def.b);
  const pbd::Vec3 anchor = from_c(def.anchor);
  switch (def.kind) {
    case TANDEM_FIXED:
      return mounted(pbd::fixed_joint_at(world, a, b, anchor), def);
    case TANDEM_BALL:
      return mounted(pbd::ball_joint_at(world, a, b, anchor), def);
    case TANDEM_HINGE: {
      pbd::HingeJointDef hinge = pbd::hinge_joint_at(world, a, b, anchor, from_c(def.axis));
      hinge.axis = axis_of(def);
      return mounted(hinge, def);
    }
    case TANDEM_SLIDER: {
      pbd::SliderJointDef slider = pbd::slider_joint_at(world, a, b, anchor, from_c(def.axis));
      slider.axis = axis_of(def);
      return mounted(slider, def);
    }
  }
  refuse_unlisted("kind", def.kind, "tandem_joint_kind");
}

/// The free coordinate of a hinge (3) or a slider (0); -1 for others.
int free_axis(const pbd::SixDofJointDef& def) {
  int found = -1;
  for (int i = 0; i < 6; ++i) {
    const auto k = static_cast<std::size_t>(i % 3);
    const pbd::JointAxis& axis = i < 3 ? def.linear[k] : def.angular[k];
    if (axis.freedom == pbd::Freedom::Locked) continue;
    if (found >= 0) return -1;
    found = i;
  }
  return found;
}

}  // namespace

void tandem_joint_def_init(tandem_joint_def* def, tandem_joint_kind kind) {
  if (def == nullptr) return;
  *def = {};
  def->kind = kind;
  def->a = def->b = TANDEM_NO_BODY;
  def->axis = {1.0, 0.0, 0.0};
  def->motor = TANDEM_MOTOR_OFF;
  def->motor_max_force = pbd::kUnlimited;
}

tandem_result tandem_joint_add(tandem_world* world, const tandem_joint_def* def,
                               tandem_joint* joint, tandem_error* error) {
  return guarded(error, [&] {
    tandem_world& w = required(world, "world");
    tandem_joint& out = required(joint, "joint");
    out = to_c(w.joints.add(w.world, joint_of(w.world, required(def, "def"))));
  });
}

tandem_result tandem_joint_remove(tandem_world* world, tandem_joint joint, tandem_error* error) {
  return guarded(error, [&] { required(world, "world").joints.remove(from_c(joint)); });
}

tandem_result tandem_joint_set_motor(tandem_world* world, tandem_joint joint,
                                     tandem_motor_mode mode, double target, double max_force,
                                     tandem_error* error) {
  return tandem_joint_set_servo(world, joint, mode, target, 0.0, 0.0, max_force, error);
}

tandem_result tandem_joint_set_servo(tandem_world* world, tandem_joint joint,
                                     tandem_motor_mode mode, double target, double stiffness,
                                     double damping, double max_force, tandem_error* error) {
  return guarded(error, [&] {
    tandem_world& w = required(world, "world");
    pbd::SixDofJointDef def = w.joints.def(from_c(joint));
    const int axis = free_axis(def);
    if (axis < 0) pbd::detail::refuse("joint", "a hinge or a slider");
    const auto k = static_cast<std::size_t>(axis % 3);
    pbd::JointMotor& motor = (axis < 3 ? def.linear[k] : def.angular[k]).motor;
    motor = motor_of(mode, target, max_force);
    motor.stiffness = stiffness;
    motor.damping = damping;
    w.joints.set(w.world, from_c(joint), def);
  });
}

tandem_result tandem_joint_position(const tandem_world* world, tandem_joint joint, double* position,
                                    int32_t* broken, tandem_error* error) {
  return guarded(error, [&] {
    const tandem_world& w = required(world, "world");
    double& out = required(position, "position");
    const pbd::JointState& state = w.joints.at(from_c(joint));
    const int axis = free_axis(w.joints.def(from_c(joint)));
    out = axis < 0 ? 0.0 : state.position[static_cast<std::size_t>(axis)];
    if (broken != nullptr) *broken = state.broken ? 1 : 0;
  });
}
