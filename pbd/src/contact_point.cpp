// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_point.h"

#include <algorithm>
#include <cmath>

#include "contact_motion.h"

namespace tandem::pbd {
namespace {

/// rub(): the change of F_1 and F_2, N s.
std::array<double, 2> rub_point(ContactRow& row, double slip_1, double slip_2) {
  const std::array<double, 2> before = row.slide;
  const auto [m11, m12, m22] = row.grip;
  const double scale = 1.0 / (m11 * m22 - m12 * m12);
  std::array<double, 2> slide{before[0] - scale * (m22 * slip_1 - m12 * slip_2),
                              before[1] - scale * (m11 * slip_2 - m12 * slip_1)};
  const double limit = row.friction * row.impulse[0];
  if (!(limit > 0.0)) {
    slide = {};
  } else {
    const double u = std::sqrt(slide[0] * slide[0] + slide[1] * slide[1]) / limit;
    if (!(u * u <= 1.0)) {
      slide[0] /= u;
      slide[1] /= u;
    }
  }
  row.slide = slide;
  return {slide[0] - before[0], slide[1] - before[1]};
}

}  // namespace

void warm_start_point(const ContactRow& row, SolverBody& a, SolverBody& b) {
  const Vec3 force = row.impulse[0] * row.normal + row.slide[0] * row.t1 + row.slide[1] * row.t2();
  apply_force(row, force, a, b, &SolverBody::v, &SolverBody::w);
}

double solve_point(ContactRow& row, ContactPass pass, int turns, SolverBody& a, SolverBody& b) {
  const Vec3 velocity = relative_velocity(row, a, b);
  double e = row.normal.dot(velocity);
  const double before = row.impulse[0];
  // As solve_row().
  const bool motion = pass == ContactPass::Motion;
  if (motion || before <= 0.0) e += std::max(row.bias[0], 0.0);
  if (!motion && row.bounces) e -= row.bounce[0];
  if (!(e < 0.0 || before > 0.0)) return 0.0;
  const double B = row.press_n;
  const double change = std::abs(std::min(e, B * before));
  const Vec3 t2 = row.t2();
  const double slip_1 = row.t1.dot(velocity);
  const double slip_2 = t2.dot(velocity);
  double pressed = 0.0;  // N s, change so far
  double rubbed_1 = 0.0;
  double rubbed_2 = 0.0;
  for (int turn = 0; turn < turns; ++turn) {
    const double dz = B > 0.0 ? std::max(-row.impulse[0], -e / B) : 0.0;
    row.impulse[0] += dz;
    pressed += dz;
    if (!row.rubs()) break;
    const auto [m11, m12, m22] = row.grip;
    const auto [d1, d2] =
        rub_point(row, slip_1 + row.slip_n[0] * pressed + (m11 * rubbed_1 + m12 * rubbed_2),
                  slip_2 + row.slip_n[1] * pressed + (m12 * rubbed_1 + m22 * rubbed_2));
    rubbed_1 += d1;
    rubbed_2 += d2;
    if (turn + 1 == turns) break;
    e += B * dz + (row.slip_n[0] * d1 + row.slip_n[1] * d2);
  }
  const Vec3 force = pressed * row.normal + rubbed_1 * row.t1 + rubbed_2 * t2;
  apply_force(row, force, a, b, &SolverBody::v, &SolverBody::w);
  return change;
}

bool push_point(const ContactRow& row, SolverBody& a, SolverBody& b) {
  const Vec3 velocity = b.v_push - a.v_push + b.w_push.cross(row.arm_b) - a.w_push.cross(row.arm_a);
  const double e = row.normal.dot(velocity) + row.bias[0];
  if (!(e < 0.0)) return false;
  const double dz = row.press_n > 0.0 ? std::max(-0.0, -e / row.press_n) : 0.0;
  apply_force(row, dz * row.normal, a, b, &SolverBody::v_push, &SolverBody::w_push);
  return true;
}

}  // namespace tandem::pbd
