// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Field names of definitions in the format, once for reading and writing: io(name, field) for each.
#pragma once

#include <array>
#include <string_view>

#include "tandem/scene.h"

namespace tandem::scene_files {

/// The names of an enumeration's values, in order.
template <class Enum>
struct EnumNames;
template <>
struct EnumNames<BodyType> {
  static constexpr std::array<std::string_view, 3> kAll{"static", "kinematic", "dynamic"};
};
template <>
struct EnumNames<collision::Combine> {
  static constexpr std::array<std::string_view, 6> kAll{"default", "geometricMean", "average",
                                                        "minimum", "multiply",      "maximum"};
};
template <>
struct EnumNames<pbd::Freedom> {
  static constexpr std::array<std::string_view, 3> kAll{"free", "locked", "limited"};
};
template <>
struct EnumNames<pbd::MotorMode> {
  static constexpr std::array<std::string_view, 3> kAll{"off", "velocity", "position"};
};

void fields(auto& io, Pose& pose) {
  io("position", pose.position);
  io("orientation", pose.orientation);
}

void fields(auto& io, pbd::JointFrame& frame) {
  io("position", frame.anchor);
  io("orientation", frame.basis);
}

void fields(auto& io, collision::Filter& filter) {
  io("category", filter.category);
  io("mask", filter.mask);
  io("group", filter.group);
}

void fields(auto& io, collision::Material& material) {
  io("friction", material.friction);
  io("restitution", material.restitution);
  io("frictionRule", material.friction_rule);
  io("restitutionRule", material.restitution_rule);
}

void fields(auto& io, pbd::AxisLocks& locks) {
  io("linear", locks.linear);
  io("angular", locks.angular);
}

/// Fields common to pbd::BodyDef and SolidDef.
template <class Io, class Def>
void body_fields(Io& io, Def& def) {
  io("type", def.type);
  fields(io, def.pose);
  io("linearVelocity", def.twist.linear);
  io("angularVelocity", def.twist.angular);
  io("gravityScale", def.gravity_scale);
  io("linearDamping", def.linear_damping);
  io("angularDamping", def.angular_damping);
  io("locks", def.locks);
  io("bullet", def.bullet);
  io("canSleep", def.can_sleep);
  io("sleepSpeed", def.sleep_speed);
  io("sleepSpin", def.sleep_spin);
  io("stableId", def.stable_id);
  io("userData", def.user_data);
}

void fields(auto& io, pbd::BodyDef& def) {
  body_fields(io, def);
  io("mass", def.mass);
  io("inertia", def.inertia);
  io("origin", def.origin);
}

void fields(auto& io, SolidDef& def) {
  body_fields(io, def);
  io("density", def.density);
  io("mass", def.mass);
  fields(io, def.material);
  io("filter", def.filter);
  io("sensor", def.sensor);
}

void fields(auto& io, collision::ColliderDef& def) {
  io("shape", def.shape);
  fields(io, def.local);
  fields(io, def.material);
  io("filter", def.filter);
  io("sensor", def.sensor);
  io("passive", def.passive);
  io("userData", def.user_data);
}

void fields(auto& io, collision::CompoundPart& part) {
  io("shape", part.shape);
  fields(io, part.local);
  io("density", part.density);
}

void fields(auto& io, pbd::JointSpring& spring) {
  io("stiffness", spring.stiffness);
  io("rest", spring.rest);
  io("damping", spring.damping);
  io("frequency", spring.frequency);
  io("dampingRatio", spring.damping_ratio);
}

void fields(auto& io, pbd::JointMotor& motor) {
  io("mode", motor.mode);
  io("target", motor.target);
  io("maxForce", motor.max_force);
  io("maxSpeed", motor.max_speed);
  io("stiffness", motor.stiffness);
  io("damping", motor.damping);
}

void fields(auto& io, pbd::JointAxis& axis) {
  io("freedom", axis.freedom);
  io("lower", axis.lower);
  io("upper", axis.upper);
  io("compliance", axis.compliance);
  io("damping", axis.damping);
  io("spring", axis.spring);
  io("motor", axis.motor);
  io("friction", axis.friction);
  io("armature", axis.armature);
}

void fields(auto& io, pbd::BallDrive::Spring& spring) {
  io("stiffness", spring.stiffness);
  io("damping", spring.damping);
  io("frequency", spring.frequency);
  io("dampingRatio", spring.damping_ratio);
  io("rest", spring.rest);
}

void fields(auto& io, pbd::BallDrive::Motor& motor) {
  io("mode", motor.mode);
  io("velocity", motor.velocity);
  io("target", motor.target);
  io("maxTorque", motor.max_torque);
  io("maxSpeed", motor.max_speed);
}

void fields(auto& io, pbd::BallDrive& drive) {
  io("spring", drive.spring);
  io("motor", drive.motor);
  io("friction", drive.friction);
  io("armature", drive.armature);
}

/// Fields common to all joints; bodies are named, and so read and written separately.
template <class Io, class Def>
void joint_fields(Io& io, Def& def) {
  io("frameA", def.frame_a);
  io("frameB", def.frame_b);
  io("breakForce", def.break_force);
  io("breakTorque", def.break_torque);
  io("collideConnected", def.collide_connected);
}

void fields(auto& io, pbd::SixDofJointDef& def) {
  joint_fields(io, def);
  io("linear", def.linear);
  io("angular", def.angular);
  io("cone", def.cone);
  io("coneCompliance", def.cone_compliance);
  io("coneDamping", def.cone_damping);
  io("drive", def.drive);
  io("start", def.start);
  io("enabled", def.enabled);
}

/// Fields common to all short forms of joints.
template <class Io, class Def>
void short_fields(Io& io, Def& def) {
  joint_fields(io, def);
  io("compliance", def.compliance);
  io("damping", def.damping);
  io("angularCompliance", def.angular_compliance);
  io("angularDamping", def.angular_damping);
}

void fields(auto& io, pbd::FixedJointDef& def) { short_fields(io, def); }

void fields(auto& io, pbd::BallJointDef& def) {
  short_fields(io, def);
  io("cone", def.cone);
  io("limitTwist", def.limit_twist);
  io("lowerTwist", def.lower_twist);
  io("upperTwist", def.upper_twist);
  io("drive", def.drive);
}

void fields(auto& io, pbd::HingeJointDef& def) {
  short_fields(io, def);
  io("axis", def.axis);
  io("start", def.start);
}

void fields(auto& io, pbd::SliderJointDef& def) {
  short_fields(io, def);
  io("axis", def.axis);
}

void fields(auto& io, pbd::WheelJointDef& def) {
  short_fields(io, def);
  io("suspension", def.suspension);
  io("steer", def.steer);
  io("drive", def.drive);
  io("brake", def.brake);
}

}  // namespace tandem::scene_files
