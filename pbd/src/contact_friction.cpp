// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_friction.h"

#include <algorithm>
#include <cmath>

namespace tandem::pbd {
namespace {

/// How far friction reaches for the load that the normals carry.
struct FrictionLimit {
  double slide = 0.0;  ///< N s
  double twist = 0.0;  ///< N m s; the load's spread about its centre turns it into a moment
};

FrictionLimit friction_limit(const ContactRow& row) {
  FrictionLimit limit;
  limit.slide = row.friction * sum(row.impulse);
  limit.twist = row.friction * sum(row.impulse * (row.s.square() + row.r.square()).sqrt());
  return limit;
}

/// Cut the multipliers back to the ellipsoid at the point where friction dissipates most: a body
/// that spins fast hardly resists being pushed. Two limits of their own would brake such a body
/// twice over.
void keep_within(ContactRow& row, const FrictionLimit& limit) {
  if (!(limit.slide > 0.0)) {
    row.slide = {};
    row.twist = 0.0;
    return;
  }
  const bool twists = row.mw > 0.0 && limit.twist > 0.0;
  if (!twists) row.twist = 0.0;
  const double slide = std::sqrt(row.slide[0] * row.slide[0] + row.slide[1] * row.slide[1]);
  const double u = slide / limit.slide;
  const double v = twists ? row.twist / limit.twist : 0.0;
  if (u * u + v * v <= 1.0) return;
  if (v == 0.0) {
    row.slide[0] /= u;
    row.slide[1] /= u;
    return;
  }
  constexpr int kIterations = 10;
  const double m_slide = 2.0 * (row.m11 * row.m22 - row.m12 * row.m12) / (row.m11 + row.m22);
  const double p = m_slide * limit.slide * limit.slide;
  const double q = row.mw * limit.twist * limit.twist;
  // The bound's own multiplier, by Newton's iteration on 1 / use - 1, which is nearly straight.
  const double a = m_slide * slide * limit.slide;
  const double b = row.mw * std::abs(row.twist) * limit.twist;
  double bound = 0.0;
  double use = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const double s = a / (p + bound);
    const double t = b / (q + bound);
    use = std::sqrt(s * s + t * t);
    if (use <= 1.0 + 1e-6) break;
    bound += (use - 1.0) * use * use / (s * s / (p + bound) + t * t / (q + bound));
  }
  const double rest = std::max(1.0, use);
  const double slide_scale = p / ((p + bound) * rest);
  row.slide[0] *= slide_scale;
  row.slide[1] *= slide_scale;
  row.twist *= q / ((q + bound) * rest);
}

}  // namespace

void rub(ContactRow& row, const Vec3& slip, ContactWrench& wrench) {
  const std::array<double, 2> slide = row.slide;
  const double twist = row.twist;
  const double scale = 1.0 / (row.m11 * row.m22 - row.m12 * row.m12);
  row.slide[0] -= scale * (row.m22 * slip[0] - row.m12 * slip[1]);
  row.slide[1] -= scale * (row.m11 * slip[1] - row.m12 * slip[0]);
  if (row.mw > 0.0) row.twist -= slip[2] / row.mw;
  keep_within(row, friction_limit(row));
  wrench.force[1] = row.slide[0] - slide[0];
  wrench.force[2] = row.slide[1] - slide[1];
  wrench.couple[0] = row.twist - twist;
}

}  // namespace tandem::pbd
