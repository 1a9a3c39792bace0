// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/joint_def.h"

#include <cmath>
#include <string>

#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

constexpr std::string_view kKind = "joint";

/// Name of a checked field, put into words only on failure: joints are set within steps.
struct JointField {
  std::string_view name;
  int place = -1;              ///< index in "name[place]"; none if negative
  std::string_view part = {};  ///< ".part", or empty

  JointField operator/(std::string_view of_it) const { return {name, place, of_it}; }
  std::string text() const {
    std::string text(name);
    if (place >= 0) text.append("[").append(std::to_string(place)).append("]");
    if (!part.empty()) text.append(".").append(part);
    return text;
  }
};

void demand(bool ok, const JointField& field, double value, std::string_view rule) {
  if (!ok) detail::require(ok, kKind, field.text(), value, rule);
}

void check_at_least_0(double value, const JointField& field) {
  demand(value >= 0.0 && std::isfinite(value), field, value, "finite and >= 0");
}

void check_compliance(double value, const JointField& field) {
  const bool ok = value == 0.0 || (value >= kMinCompliance && std::isfinite(value));
  demand(ok, field, value, "0, or finite and at least 1e-100");
}

/// Checks the spring of an axis or of a ball.
void check_spring(const auto& spring, const JointField& field) {
  check_at_least_0(spring.stiffness, field / "spring.stiffness");
  check_at_least_0(spring.damping, field / "spring.damping");
  check_at_least_0(spring.frequency, field / "spring.frequency");
  check_at_least_0(spring.damping_ratio, field / "spring.damping_ratio");
  if (spring.frequency > 0.0) {
    demand(spring.stiffness == 0.0, field / "spring.stiffness", spring.stiffness,
           "0 where there is a frequency");
    demand(spring.damping == 0.0, field / "spring.damping", spring.damping,
           "0 where there is a frequency, which goes with a damping_ratio");
  } else {
    demand(spring.damping_ratio == 0.0, field / "spring.damping_ratio", spring.damping_ratio,
           "0 without a frequency");
  }
}

bool is_unit(const Quat& q) { return std::abs(q.norm() - 1.0) <= 1e-3; }

void check_servo(const JointMotor& motor, const JointField& field) {
  check_at_least_0(motor.stiffness, field / "motor.stiffness");
  check_at_least_0(motor.damping, field / "motor.damping");
  if (!motor.is_servo()) return;
  if (motor.mode == MotorMode::Velocity) {
    demand(motor.stiffness == 0.0, field / "motor.stiffness", motor.stiffness,
           "0 of a servo to a speed");
  } else {
    demand(motor.stiffness > 0.0, field / "motor.stiffness", motor.stiffness,
           "> 0 of a servo to a position");
  }
  demand(motor.max_speed == kUnlimited, field / "motor.max_speed", motor.max_speed,
         "infinite of a servo");
}

void check_axis(const JointAxis& axis, const JointField& field) {
  check_compliance(axis.compliance, field / "compliance");
  check_at_least_0(axis.damping, field / "damping");
  if (axis.freedom == Freedom::Free) {
    demand(axis.damping == 0.0, field / "damping", axis.damping,
           "0 on a free axis, which has no stops to damp (spring.damping damps its motion)");
    demand(axis.compliance == 0.0, field / "compliance", axis.compliance,
           "0 on a free axis, which has no stops to give way");
  }
  check_at_least_0(axis.friction, field / "friction");
  check_at_least_0(axis.armature, field / "armature");
  check_spring(axis.spring, field);
  demand(std::isfinite(axis.spring.rest), field / "spring.rest", axis.spring.rest, "finite");
  demand(std::isfinite(axis.motor.target), field / "motor.target", axis.motor.target, "finite");
  demand(axis.motor.max_force > 0.0, field / "motor.max_force", axis.motor.max_force, "> 0");
  demand(axis.motor.max_speed > 0.0, field / "motor.max_speed", axis.motor.max_speed, "> 0");
  check_servo(axis.motor, field);
  if (axis.freedom == Freedom::Limited) {
    demand(axis.lower < kUnlimited, field / "lower", axis.lower, "a number below infinity");
    demand(axis.upper > -kUnlimited, field / "upper", axis.upper, "a number above -infinity");
    demand(axis.upper >= axis.lower, field / "upper", axis.upper, ">= lower");
  }
  if (axis.freedom == Freedom::Locked) {
    demand(axis.motor.mode == MotorMode::Off, field / "motor.mode",
           static_cast<double>(axis.motor.mode), "off on a locked axis");
    demand(axis.spring.stiffness == 0.0 && axis.spring.damping == 0.0, field / "spring.stiffness",
           axis.spring.stiffness, "0 on a locked axis");
    demand(axis.spring.frequency == 0.0, field / "spring.frequency", axis.spring.frequency,
           "0 on a locked axis");
    demand(axis.friction == 0.0, field / "friction", axis.friction, "0 on a locked axis");
    demand(axis.armature == 0.0, field / "armature", axis.armature, "0 on a locked axis");
  }
}

/// Whether any part of the drive acts.
bool is_on(const BallDrive& drive) {
  return drive.spring.stiffness > 0.0 || drive.spring.damping > 0.0 ||
         drive.spring.frequency > 0.0 || drive.motor.mode != MotorMode::Off ||
         drive.friction > 0.0 || drive.armature > 0.0;
}

void check_drive(const SixDofJointDef& def) {
  const BallDrive& drive = def.drive;
  const JointField field{"drive"};
  check_spring(drive.spring, field);
  demand(is_unit(drive.spring.rest), field / "spring.rest", drive.spring.rest.norm(),
         "a unit quaternion");
  detail::require_finite(drive.motor.velocity, kKind, "drive.motor.velocity");
  demand(is_unit(drive.motor.target), field / "motor.target", drive.motor.target.norm(),
         "a unit quaternion");
  demand(drive.motor.max_torque > 0.0, field / "motor.max_torque", drive.motor.max_torque, "> 0");
  demand(drive.motor.max_speed > 0.0, field / "motor.max_speed", drive.motor.max_speed, "> 0");
  check_at_least_0(drive.friction, field / "friction");
  check_at_least_0(drive.armature, field / "armature");
  for (int i = 0; is_on(drive) && i < 3; ++i) {
    const JointAxis& axis = def.angular[static_cast<std::size_t>(i)];
    const JointField at{"angular", i};
    demand(axis.freedom != Freedom::Locked, at / "freedom", static_cast<double>(axis.freedom),
           "free or limited where the joint has a drive");
    demand(axis.motor.mode == MotorMode::Off, at / "motor.mode",
           static_cast<double>(axis.motor.mode), "off where the joint has a drive");
    demand(axis.friction == 0.0, at / "friction", axis.friction, "0 where the joint has a drive");
    demand(axis.armature == 0.0, at / "armature", axis.armature, "0 where the joint has a drive");
    const double spring = axis.spring.stiffness + axis.spring.damping + axis.spring.frequency;
    demand(spring == 0.0, at / "spring", spring, "0 where the joint has a drive");
  }
}

JointAxis locked(double compliance, double damping) {
  return {.freedom = Freedom::Locked, .compliance = compliance, .damping = damping};
}

/// A held point, from the fields common to all short forms.
SixDofJointDef base(const auto& def) {
  SixDofJointDef six;
  six.a = def.a;
  six.b = def.b;
  six.frame_a = def.frame_a;
  six.frame_b = def.frame_b;
  six.linear.fill(locked(def.compliance, def.damping));
  six.break_force = def.break_force;
  six.break_torque = def.break_torque;
  six.collide_connected = def.collide_connected;
  return six;
}

/// base() with both frames at one place in the world.
template <class Def>
Def at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w, const Quat& basis_w) {
  detail::require_body(world, b, kKind, "b");
  if (a.valid()) detail::require_body(world, a, kKind, "a");
  const auto frame = [&](BodyId id) -> JointFrame {
    if (!id.valid()) return {anchor_w, basis_w};
    const Pose& pose = world.pose(id);
    return {pose.to_local(anchor_w), (pose.orientation.conjugate() * basis_w).normalized()};
  };
  Def def;
  def.a = a;
  def.b = b;
  def.frame_a = frame(a);
  def.frame_b = frame(b);
  return def;
}

Quat basis_along(const Vec3& axis_w) {
  detail::require_finite(axis_w, kKind, "axis_w");
  double length = axis_w.norm();
  if (!std::isfinite(length)) length = axis_w.stableNorm();  // its square overflows
  detail::require(length > 1e-9 && std::isfinite(length), kKind, "axis_w", length,
                  "longer than 1e-9");
  Mat3 basis;
  Vec3 y;
  Vec3 z;
  basis.col(0) = axis_w / length;
  tangent_frame(basis.col(0), y, z);
  basis.col(1) = y;
  basis.col(2) = z;
  return Quat(basis).normalized();
}

}  // namespace

FixedJointDef::operator SixDofJointDef() const {
  SixDofJointDef six = base(*this);
  six.angular.fill(locked(angular_compliance, angular_damping));
  return six;
}

BallJointDef::operator SixDofJointDef() const {
  SixDofJointDef six = base(*this);
  six.cone = cone;
  six.cone_compliance = angular_compliance;
  six.cone_damping = angular_damping;
  six.drive = drive;
  if (limit_twist) {
    six.angular[0] = {.freedom = Freedom::Limited,
                      .lower = lower_twist,
                      .upper = upper_twist,
                      .compliance = angular_compliance,
                      .damping = angular_damping};
  }
  return six;
}

HingeJointDef::operator SixDofJointDef() const {
  SixDofJointDef six = base(*this);
  six.angular.fill(locked(angular_compliance, angular_damping));
  six.angular[0] = axis;
  six.start = start;
  return six;
}

SliderJointDef::operator SixDofJointDef() const {
  SixDofJointDef six = base(*this);
  six.angular.fill(locked(angular_compliance, angular_damping));
  six.linear[0] = axis;
  return six;
}

WheelJointDef::operator SixDofJointDef() const {
  detail::require_finite(Vec3::Constant(steer), kKind, "steer");
  check_at_least_0(brake, {"brake"});
  SixDofJointDef six = base(*this);
  six.angular.fill(locked(angular_compliance, angular_damping));
  six.linear[2] = suspension;
  six.angular[0] = {.freedom = Freedom::Free, .motor = drive};
  if (brake > 0.0) {
    six.angular[0].motor = {.mode = MotorMode::Velocity, .target = 0.0, .max_force = brake};
  }
  six.frame_a.basis = six.frame_a.basis * exp_map(steer * Vec3::UnitZ());
  return six;
}

SixDofJointDef six_dof_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w,
                                const Vec3& axis_w) {
  return at<SixDofJointDef>(world, a, b, anchor_w, basis_along(axis_w));
}
FixedJointDef fixed_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w) {
  return at<FixedJointDef>(world, a, b, anchor_w, Quat::Identity());
}
BallJointDef ball_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w,
                           const Vec3& twist_axis_w) {
  return at<BallJointDef>(world, a, b, anchor_w, basis_along(twist_axis_w));
}
HingeJointDef hinge_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w,
                             const Vec3& axis_w) {
  return at<HingeJointDef>(world, a, b, anchor_w, basis_along(axis_w));
}
SliderJointDef slider_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w,
                               const Vec3& axis_w) {
  return at<SliderJointDef>(world, a, b, anchor_w, basis_along(axis_w));
}

WheelJointDef wheel_joint_at(const World& world, BodyId chassis, BodyId wheel, const Vec3& anchor_w,
                             const Vec3& axle_w, const Vec3& up_w) {
  const Vec3 x = basis_along(axle_w) * Vec3::UnitX();
  const Vec3 z = basis_along(up_w - up_w.dot(x) * x) * Vec3::UnitX();
  Mat3 basis;
  basis << x, z.cross(x), z;
  return at<WheelJointDef>(world, chassis, wheel, anchor_w, Quat(basis).normalized());
}

void check_joint(const World& world, const SixDofJointDef& def) {
  if (def.a.valid()) detail::require_body(world, def.a, kKind, "a");
  detail::require_body(world, def.b, kKind, "b");
  detail::require(def.a != def.b, kKind, "b", def.b.index, "another body than a");
  detail::require_finite(def.frame_a.anchor, kKind, "frame_a.anchor");
  detail::require_unit(def.frame_a.basis, kKind, "frame_a.basis");
  detail::require_finite(def.frame_b.anchor, kKind, "frame_b.anchor");
  detail::require_unit(def.frame_b.basis, kKind, "frame_b.basis");
  for (int i = 0; i < 3; ++i) {
    check_axis(def.linear[static_cast<std::size_t>(i)], {"linear", i});
    check_axis(def.angular[static_cast<std::size_t>(i)], {"angular", i});
  }
  demand(def.cone > 0.0, {"cone"}, def.cone, "> 0");
  for (int i = 1; i < 3 && def.cone < kUnlimited; ++i) {
    const Freedom freedom = def.angular[static_cast<std::size_t>(i)].freedom;
    demand(freedom == Freedom::Free, {"angular", i, "freedom"}, static_cast<double>(freedom),
           "free where a cone limits");
  }
  check_compliance(def.cone_compliance, {"cone_compliance"});
  check_at_least_0(def.cone_damping, {"cone_damping"});
  check_at_least_0(def.break_force, {"break_force"});
  check_at_least_0(def.break_torque, {"break_torque"});
  demand(std::isfinite(def.start), {"start"}, def.start, "finite");
  check_drive(def);
}

}  // namespace tandem::pbd
