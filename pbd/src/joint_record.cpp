// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_record.h"

#include <numbers>

#include "byte_fields.h"
#include "joint_spring.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

// Lists fields for saving or loading.
void axis_fields(auto& io, auto& axis) {
  io(axis.freedom, axis.motor.mode, axis.lower, axis.upper, axis.compliance, axis.damping,
     axis.spring.stiffness, axis.spring.rest, axis.spring.damping, axis.spring.frequency,
     axis.spring.damping_ratio, axis.friction, axis.armature, axis.motor.target,
     axis.motor.max_force, axis.motor.max_speed, axis.motor.stiffness, axis.motor.damping);
}

void record_fields(auto& io, auto& record, auto& def, auto& state) {
  io(def.a, def.b, def.frame_a.anchor, def.frame_a.basis, def.frame_b.anchor, def.frame_b.basis);
  for (auto& axis : def.linear) axis_fields(io, axis);
  for (auto& axis : def.angular) axis_fields(io, axis);
  io(def.cone, def.cone_compliance, def.cone_damping, def.break_force, def.break_torque, def.start,
     def.enabled, def.collide_connected);
  auto& spring = def.drive.spring;
  auto& motor = def.drive.motor;
  io(spring.stiffness, spring.damping, spring.frequency, spring.damping_ratio, spring.rest,
     motor.mode, motor.velocity, motor.target, motor.max_torque, motor.max_speed,
     def.drive.friction, def.drive.armature, record.drive.start);
  io(record.alive, record.displacement_residual, record.twist, record.gap.least, record.gap.stalled,
     record.energy_excess, record.last.h, record.spring_mass);
  io(state.position, state.swing, record.last.forces, record.last.rotors, record.last.rotors_known,
     state.force, state.torque, state.residual, state.broken);
}

}  // namespace

namespace {

/// Friction as a motor at speed 0; a spring given by frequency gets stiffness and damping.
JointAxis resolved(JointAxis axis, double mass) {
  if (axis.friction > 0.0 && axis.motor.mode == MotorMode::Off) {
    axis.motor = {.mode = MotorMode::Velocity, .target = 0.0, .max_force = axis.friction};
  }
  if (axis.spring.frequency > 0.0) {
    const double rate = 2.0 * std::numbers::pi * axis.spring.frequency;
    axis.spring.stiffness = mass * rate * rate;
    axis.spring.damping = 2.0 * axis.spring.damping_ratio * rate * mass;
  }
  return axis;
}

}  // namespace

void JointRecord::resolve() {
  JointAxis cone;
  if (def.cone < kUnlimited) cone.freedom = Freedom::Limited;
  cone.lower = -kUnlimited;
  cone.upper = def.cone;
  cone.compliance = def.cone_compliance;
  cone.damping = def.cone_damping;
  const BallDrive& d = def.drive;
  JointAxis driven{.spring = {.stiffness = d.spring.stiffness,
                              .damping = d.spring.damping,
                              .frequency = d.spring.frequency,
                              .damping_ratio = d.spring.damping_ratio},
                   .motor = {.mode = d.motor.mode, .max_force = d.motor.max_torque},
                   .friction = d.friction,
                   .armature = d.armature};
  for (int c = 0; c < kCoordinates; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (c >= kDrive) driven.motor.target = d.motor.velocity[c - kDrive];
    const JointAxis& axis = c < 3        ? def.linear[i]
                            : c < kCone  ? def.angular[i - 3]
                            : c < kDrive ? cone
                                         : driven;
    axes[i] = c == kCone ? cone : resolved(axis, spring_mass[i]);
  }
}

void JointRecord::begin_drive(const SolverBody& a, const SolverBody& b, double substep) {
  drive.start = (a.q * def.frame_a.basis).conjugate() * (b.q * def.frame_b.basis);
  const BallDrive::Motor& motor = def.drive.motor;
  const Vec3 rest = spring_turn(rotation_between(drive.start, def.drive.spring.rest),
                                Eigen::Map<const Vec3>(&spring_mass[kDrive]));
  drive.left = rotation_between(drive.start, motor.target);
  const double reach = substep * motor.max_speed;
  const double length = drive.left.norm();
  const Vec3 target = motor.mode == MotorMode::Velocity ? motor.velocity
                      : length > reach                  ? Vec3(reach / length * drive.left)
                                                        : drive.left;
  for (int i = 0; i < 3; ++i) {
    JointAxis& axis = axes[kDrive + static_cast<std::size_t>(i)];
    axis.spring.rest = rest[i];
    if (motor.mode != MotorMode::Off) axis.motor.target = target[i];
  }
}

void JointRecord::assign(const SixDofJointDef& from) {
  def = from;
  def.frame_a.basis.normalize();
  def.frame_b.basis.normalize();
  def.drive.spring.rest.normalize();
  def.drive.motor.target.normalize();
  const auto earlier = axes;
  refresh();
  for (int c = 0; c < kCoordinates; ++c) {
    if (axis(c).armature != earlier[static_cast<std::size_t>(c)].armature)
      last.rotors_known = false;
  }
}

void JointRecord::refresh() {
  const auto locks = [&](int axis) {
    return def.angular[static_cast<std::size_t>(axis % 3)].freedom == Freedom::Locked;
  };
  turning = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (!locks(axis) && locks(axis + 1) && locks(axis + 2)) turning = axis;
  }
  resolve();
  used = 0;
  passive = true;
  for (int c = 0; c < kCoordinates; ++c) {
    const JointAxis& a = axis(c);
    if (a.compliance > 0.0 || a.armature > 0.0 || is_powered(a)) passive = false;
    if (a.freedom != Freedom::Free || a.motor.mode != MotorMode::Off || a.spring.stiffness > 0.0 ||
        a.spring.damping > 0.0 || a.spring.frequency > 0.0 || a.armature > 0.0) {
      used |= 1u << c;
    } else {
      displacement_residual[c] = 0.0;  // no row lets it decay
    }
  }
  point = true;
  for (const JointAxis& a : def.linear) {
    point = point && a.freedom == Freedom::Locked && a.compliance == def.linear[0].compliance &&
            a.damping == def.linear[0].damping;
  }
}

void coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b, double near,
                 double* c) {
  if (record.is_point()) {
    Eigen::Map<Vec3>{c} = JointPlace::of(record.def, a, b).d;
  } else {
    all_coordinates(record, a, b, near, c);
  }
}

void all_coordinates(const JointRecord& record, const SolverBody& a, const SolverBody& b,
                     double near, double* c) {
  const SixDofJointDef& def = record.def;
  const JointPlace place = JointPlace::of(def, a, b);
  if (record.point) Eigen::Map<Vec3>{c} = place.d;
  const Quat basis_a = a.q * def.frame_a.basis;
  if (!record.point) Eigen::Map<Vec3>{c} = basis_a.conjugate() * place.d;
  const Quat rel = basis_a.conjugate() * (b.q * def.frame_b.basis);
  const JointTurn turn = JointTurn::of(turned_axes(rel, record.turning));
  const bool locked = record.turning_axis().freedom == Freedom::Locked;
  c[record.turn(0)] = locked ? turn.twist : nearest_turn(turn.twist, near);
  c[record.turn(1)] = turn.swing(1);
  c[record.turn(2)] = turn.swing(2);
  c[kCone] = record.turning == 0 ? turn.phi : JointTurn::of(rel).phi;
  Eigen::Map<Vec3> driven(c + kDrive);
  driven.setZero();
  if ((record.used >> kDrive) != 0) driven = rotation_between(record.drive.start, rel);
}

void JointRecord::clear_forces() {
  last.forces.fill(0.0);
  state.load.fill(0.0);
  state.force.setZero();
  state.torque.setZero();
}

void JointRecord::tell(const SolverBody& a, const double* c) {
  std::copy_n(c, 6, state.position.begin());
  if (point) {
    Eigen::Map<Vec3>{state.position.data()} =
        (a.q * def.frame_a.basis).conjugate() * Vec3(c[0], c[1], c[2]);
  }
  state.swing = c[kCone];
  twist = c[turn(0)];
}

void JointRecord::start(const SolverBody& a, const SolverBody& b) {
  double c[kCoordinates] = {};
  all_coordinates(*this, a, b, def.start, c);
  const JointAxis& axis = turning_axis();
  double& angle = c[turn(0)];
  if (axis.freedom == Freedom::Limited)
    angle = turn_within(angle, def.start, axis.lower, axis.upper);
  tell(a, c);
}

void JointRecord::forgive(const SolverBody& a, const SolverBody& b) {
  double c[kCoordinates] = {};
  coordinates(*this, a, b, twist, c);
  for (int i = 0; i < kCoordinates; ++i) displacement_residual[i] = residual_of(axis(i), c[i]);
}

void JointRecord::find_gap(const SolverBody& a, const SolverBody& b, bool displaced) {
  double c[kCoordinates] = {};
  coordinates(*this, a, b, twist, c);
  const double most = state.residual + JointGap::kTolerance;
  const JointAxis& axis = turning_axis();
  double& angle = c[turn(0)];
  if (axis.freedom == Freedom::Limited && violation(axis, angle) > most)
    twist = angle = turn_within(angle, twist, axis.lower, axis.upper);
  for_bits(used, [&](int i) {
    const double violated = residual_of(this->axis(i), c[i]);
    if (!displaced && !gap.is_open() && !(std::abs(violated) > most)) return;
    displacement_residual[i] = violated;
    if (!displaced && std::abs(violated) > most) gap.open(std::abs(violated));
  });
}

void JointRecord::aim(const SolverBody& a, const SolverBody& b, double substep) {
  coordinates(*this, a, b, twist, bound.data());
  const double apart = Eigen::Map<const Vec3>(displacement_residual.data()).norm();
  const double turned = Eigen::Map<const Eigen::Vector4d>(displacement_residual.data() + 3).norm();
  const bool agreed = a.agreed || b.agreed;  // closes at once, as agreement has opened it
  const double way = agreed ? 1.0 : std::min(1.0, substep * kClosingSpeed / apart);
  const double turn = agreed ? 1.0 : std::min(1.0, substep * kClosingSpin / turned);
  for (int i = 0; i < kCoordinates; ++i) {
    const double now = (i < 3 ? way : turn) * displacement_residual[i];
    bound[i] -= now;
    displacement_residual[i] -= now;
  }
}

void JointRecord::settle_gap() {
  double size = 0.0;
  for (const double residual : displacement_residual) size = std::max(size, std::abs(residual));
  gap.settle(size);
}

void JointRecord::save(ByteWriter& out) const {
  FieldWriter io(out);
  record_fields(io, *this, def, state);
}

void JointRecord::load(ByteReader& in) {
  FieldReader io(in);
  record_fields(io, *this, def, state);
  for (const auto* axes_read : {&def.linear, &def.angular}) {
    for (const JointAxis& read : *axes_read) {
      if (read.freedom > Freedom::Limited || read.motor.mode > MotorMode::Position) in.fail();
    }
  }
  if (def.drive.motor.mode > MotorMode::Position) in.fail();
  refresh();
  std::copy_n(last.forces.begin(), state.load.size(), state.load.begin());
  bool finite = state.force.allFinite() && state.torque.allFinite();
  for (const double value :
       {twist, def.start, gap.least, energy_excess, last.h, state.swing, state.residual}) {
    finite = finite && std::isfinite(value);
  }
  const auto check = [&](const auto& values) {
    for (const double value : values) finite = finite && std::isfinite(value);
  };
  check(displacement_residual);
  check(state.position);
  check(spring_mass);
  check(drive.start.coeffs());
  check(last.forces);
  check(last.rotors);
  if (!finite || last.h < 0.0 || gap.least < 0.0) in.fail();
}

}  // namespace tandem::pbd
