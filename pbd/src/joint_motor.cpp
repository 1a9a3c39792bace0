// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_motor.h"

namespace tandem::pbd {
namespace {

constexpr double kArrived = 1e-6;     // m or rad
constexpr double kFull = 1.0 - 1e-6;  // share of its force: from here on the load is too much

/// Whether the motor of a coordinate moves the joint.
bool motor_runs(const JointRecord& record, int c) {
  const JointAxis& axis = record.axis(c);
  const JointMotor& motor = axis.motor;
  const bool limited = axis.freedom == Freedom::Limited;
  const double lower = limited ? axis.lower : -kUnlimited;
  const double upper = limited ? axis.upper : kUnlimited;
  const double at = record.state.position[static_cast<std::size_t>(c)];
  if (motor.mode == MotorMode::Off) return false;
  // A position servo rests like a spring: it need not have arrived.
  if (motor.mode == MotorMode::Position && motor.stiffness > 0.0) return false;
  if (motor.mode == MotorMode::Velocity) {
    if (motor.target == 0.0) return false;
    if (motor.target > 0.0 ? at >= upper - kArrived : at <= lower + kArrived) return false;
  } else if (std::abs(at - std::clamp(motor.target, lower, upper)) <= kArrived) {
    return false;
  }
  // Its pull when nothing moves.
  const double most = motor.is_servo()
                          ? std::min(motor.max_force, motor.damping * std::abs(motor.target))
                          : motor.max_force;
  return !(std::abs(record.state.load[static_cast<std::size_t>(c)]) >= kFull * most);
}

/// Whether the motor of a ball moves the joint.
bool drive_runs(const JointRecord& record) {
  const BallDrive::Motor& motor = record.def.drive.motor;
  if (motor.mode == MotorMode::Off) return false;
  const bool runs = motor.mode == MotorMode::Velocity ? !motor.velocity.isZero(0.0)
                                                      : record.drive.left.norm() > kArrived;
  return runs && !(record.state.torque.norm() >= kFull * motor.max_torque);
}

}  // namespace

bool motors_run(const JointRecord& record) {
  for (int c = 0; c < kCone; ++c) {
    if (motor_runs(record, c)) return true;
  }
  return drive_runs(record);
}

}  // namespace tandem::pbd
