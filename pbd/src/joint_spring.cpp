// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_spring.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "integrate.h"
#include "joint_six_dof.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

SolverBody weighed(const World& world, BodyId id) {
  SolverBody body;
  if (!id.valid()) return body;
  body.x = world.pose(id).position;
  body.q = world.pose(id).orientation;
  body.inv_mass = world.props(id).inverse_mass;
  if (body.inv_mass > 0.0) inverse_inertia_w(body.q, world.props(id), body.inv_inertia_w);
  return body;
}

/// Change of the rate of coordinate i by an impulse along coordinate j.
double mobility(const JointRows& rows, const SolverBody& a, const SolverBody& b, int i, int j) {
  return (a.inv_mass + b.inv_mass) * rows.dir.col(i).dot(rows.dir.col(j)) +
         rows.arm_a.col(i).dot(a.inv_inertia_w * rows.arm_a.col(j)) +
         rows.arm_b.col(i).dot(b.inv_inertia_w * rows.arm_b.col(j));
}

}  // namespace

void weigh_springs(JointRecord& record, const World& world) {
  record.spring_mass.fill(0.0);
  std::uint32_t sprung = 0;
  std::uint32_t held = 0;
  for_bits(record.used, [&](int i) {
    const JointAxis& axis = record.axis(i);
    if (axis.spring.frequency > 0.0) sprung |= 1u << i;
    if (axis.freedom == Freedom::Locked && axis.compliance == 0.0) held |= 1u << i;
  });
  if (sprung == 0) return;
  const SolverBody a = weighed(world, record.def.a);
  const SolverBody b = weighed(world, record.def.b);
  JointNode node;
  JointRows rows;
  joint_six_dof::take_gradients(node, rows, record, a, b);
  for_bits(sprung, [&](int i) {
    std::array<int, kCoordinates> row{};
    int n = 0;
    for_bits(held, [&](int k) { row[n++] = k; });
    row[n++] = i;
    double values[block::kMaxRows * block::kMaxRows];
    for (int r = 0; r < n; ++r) {
      for (int s = 0; s < n; ++s) values[r * n + s] = mobility(rows, a, b, row[r], row[s]);
    }
    block::invert(values, n);
    record.spring_mass[i] = values[n * n - 1] + record.axis(i).armature;
  });
  record.resolve();
}

void tune_spring(ForceLaw& law, const JointSpring& spring, double mass, double c, double rate,
                 double h) {
  // rad: closed form for up to kResolved in a substep; beyond kBraked implicit Euler, which removes
  // energy. In between a blend.
  constexpr double kResolved = 0.5;
  constexpr double kBraked = 1.0;
  const double whole_turn = 2.0 * std::numbers::pi * spring.frequency * h;
  const double turn = std::min(whole_turn, kBraked);
  const double exact = std::clamp((kBraked - whole_turn) / (kBraked - kResolved), 0.0, 1.0);
  const double zeta = spring.damping_ratio;
  double less = 0.0;  // 1 - P + Q
  double more = 0.0;  // 1 + P + Q
  double gone = 0.0;  // 1 - Q
  if (zeta < 1.0) {
    const double shrink = -portable::expm1(-zeta * turn);
    const double part = 1.0 - shrink;
    const double sine = portable::sin_cos(0.5 * turn * std::sqrt(1.0 - zeta * zeta)).sin;
    less = shrink * shrink + 4.0 * part * sine * sine;
    more = (1.0 + part) * (1.0 + part) - 4.0 * part * sine * sine;
    gone = -portable::expm1(-2.0 * zeta * turn);
  } else {
    const double root = std::sqrt((zeta - 1.0) * (zeta + 1.0));
    const double slow = -portable::expm1(-turn / (zeta + root));
    const double fast = -portable::expm1(-turn * (zeta + root));
    less = slow * fast;
    more = (2.0 - slow) * (2.0 - fast);
    gone = slow + fast - slow * fast;
  }
  const double stiff = exact * mass * less / more;         // h^2 stiffness / 4
  const double damped = exact * 2.0 * mass * gone / more;  // h damping / 2
  const double back = c - h * rate;                        // coordinate one substep ago
  const double end_k = (1.0 - exact) * law.spring_k;
  double pull = stiff * (4.0 * spring.rest - 2.0 * c - back) + damped * back;
  if (end_k > 0.0) pull += end_k * law.spring_target;
  law.spring_k = stiff + damped + end_k;
  if (law.spring_k > 0.0) law.spring_target = pull / law.spring_k;
}

Vec3 spring_turn(const Vec3& to_rest, const Vec3& mass) {
  if (!(mass.minCoeff() > 0.0) || mass.minCoeff() == mass.maxCoeff()) return to_rest;
  // (1 - (angle / 2) cot(angle / 2)) / angle^2, with the limit 1/12.
  constexpr double kSmall = 1e-3;  // rad
  const double angle = to_rest.norm();
  double bend = 1.0 / 12.0;
  if (angle > kSmall) {
    const auto [sine, cosine] = portable::sin_cos(0.5 * angle);
    bend = (1.0 - 0.5 * angle * cosine / sine) / (angle * angle);
  }
  const Vec3 torque = mass.cwiseProduct(to_rest);
  const Vec3 across = to_rest.cross(torque);
  return (torque - 0.5 * across + bend * to_rest.cross(across)).cwiseQuotient(mass);
}

}  // namespace tandem::pbd
