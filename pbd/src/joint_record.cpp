// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_record.h"

namespace tandem::pbd {
namespace {

void save_frame(ByteWriter& out, const JointFrame& frame) {
  out.vec3(frame.anchor);
  out.quat(frame.basis);
}

void load_frame(ByteReader& in, JointFrame& frame) {
  frame.anchor = in.vec3();
  frame.basis = in.quat();
}

void save_axis(ByteWriter& out, const JointAxis& axis) {
  out.u8(static_cast<std::uint8_t>(axis.freedom));
  out.u8(static_cast<std::uint8_t>(axis.motor.mode));
  for (const double value : {axis.lower, axis.upper, axis.compliance, axis.damping,
                             axis.spring.stiffness, axis.spring.rest, axis.spring.damping,
                             axis.motor.target, axis.motor.max_force, axis.motor.max_speed}) {
    out.f64(value);
  }
}

void load_axis(ByteReader& in, JointAxis& axis) {
  axis.freedom = static_cast<Freedom>(in.u8());
  axis.motor.mode = static_cast<MotorMode>(in.u8());
  if (axis.freedom > Freedom::Limited || axis.motor.mode > MotorMode::Position) in.fail();
  for (double* value : {&axis.lower, &axis.upper, &axis.compliance, &axis.damping,
                        &axis.spring.stiffness, &axis.spring.rest, &axis.spring.damping,
                        &axis.motor.target, &axis.motor.max_force, &axis.motor.max_speed}) {
    *value = in.f64();
  }
}

}  // namespace

JointAxis JointRecord::axis(int c) const {
  if (c < 3) return def.linear[static_cast<std::size_t>(c)];
  if (c < kCone) return def.angular[static_cast<std::size_t>(c - 3)];
  JointAxis cone;
  if (def.cone < kUnlimited) cone.freedom = Freedom::Limited;
  cone.lower = -kUnlimited;
  cone.upper = def.cone;
  cone.compliance = def.cone_compliance;
  cone.damping = def.cone_damping;
  return cone;
}

void JointRecord::refresh() {
  used = 0;
  passive = true;
  for (int c = 0; c < kCoordinates; ++c) {
    const JointAxis a = axis(c);
    if (a.compliance > 0.0 || a.motor.mode != MotorMode::Off || a.spring.stiffness > 0.0) {
      passive = false;
    }
    if (a.freedom != Freedom::Free || a.motor.mode != MotorMode::Off || a.spring.stiffness > 0.0 ||
        a.spring.damping > 0.0) {
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
  const SixDofJointDef& def = record.def;
  const JointPlace place = JointPlace::of(def, a, b);
  if (record.point) {
    Eigen::Map<Vec3>{c} = place.d;
    if ((record.used >> 3) == 0) return;
  }
  const Quat basis_a = a.q * def.frame_a.basis;
  if (!record.point) Eigen::Map<Vec3>{c} = basis_a.conjugate() * place.d;
  const JointTurn turn = JointTurn::of(basis_a.conjugate() * (b.q * def.frame_b.basis));
  c[kTwist] =
      def.angular[0].freedom == Freedom::Locked ? turn.twist : nearest_turn(turn.twist, near);
  c[4] = turn.swing(1);
  c[5] = turn.swing(2);
  c[kCone] = turn.phi;
}

void JointRecord::save(ByteWriter& out) const {
  for (const BodyId id : {def.a, def.b}) {
    out.u32(id.index);
    out.u32(id.generation);
  }
  save_frame(out, def.frame_a);
  save_frame(out, def.frame_b);
  for (const JointAxis& axis : def.linear) save_axis(out, axis);
  for (const JointAxis& axis : def.angular) save_axis(out, axis);
  out.f64(def.cone);
  out.f64(def.cone_compliance);
  out.f64(def.cone_damping);
  out.f64(def.break_force);
  out.f64(def.break_torque);
  out.u8(def.enabled ? 1 : 0);
  out.u8(alive ? 1 : 0);
  for (const double value : displacement_residual) out.f64(value);
  out.f64(twist);
  out.f64(energy_excess);
  out.f64(h);
  for (const double position : state.position) out.f64(position);
  out.f64(state.swing);
  for (const double load : state.load) out.f64(load);
  out.vec3(state.force);
  out.vec3(state.torque);
  out.f64(state.residual);
  out.u8(state.broken ? 1 : 0);
}

void JointRecord::load(ByteReader& in) {
  for (BodyId* id : {&def.a, &def.b}) {
    id->index = in.u32();
    id->generation = in.u32();
  }
  load_frame(in, def.frame_a);
  load_frame(in, def.frame_b);
  for (JointAxis& axis : def.linear) load_axis(in, axis);
  for (JointAxis& axis : def.angular) load_axis(in, axis);
  def.cone = in.f64();
  def.cone_compliance = in.f64();
  def.cone_damping = in.f64();
  def.break_force = in.f64();
  def.break_torque = in.f64();
  def.enabled = in.u8() != 0;
  alive = in.u8() != 0;
  for (double& value : displacement_residual) value = in.f64();
  twist = in.f64();
  energy_excess = in.f64();
  h = in.f64();
  for (double& position : state.position) position = in.f64();
  state.swing = in.f64();
  for (double& load : state.load) load = in.f64();
  state.force = in.vec3();
  state.torque = in.vec3();
  state.residual = in.f64();
  state.broken = in.u8() != 0;
  refresh();
  bool finite = state.force.allFinite() && state.torque.allFinite();
  for (const double value : {twist, energy_excess, h, state.swing, state.residual}) {
    finite = finite && std::isfinite(value);
  }
  const auto check = [&](const auto& values) {
    for (const double value : values) finite = finite && std::isfinite(value);
  };
  check(displacement_residual);
  check(state.position);
  check(state.load);
  if (!finite || h < 0.0) in.fail();
}

}  // namespace tandem::pbd
