// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_friction.h"

#include <algorithm>
#include <cmath>

namespace tandem::pbd {
namespace {

/// Of the responses of V_1 and V_2 to F_1 and F_2.
double determinant(const ContactRow& row) {
  return row.grip[0] * row.grip[2] - row.grip[1] * row.grip[1];
}

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
  const bool twists = row.twists() && limit.twist > 0.0;
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
  const double m_slide = 2.0 * determinant(row) / (row.grip[0] + row.grip[2]);
  const double p = m_slide * limit.slide * limit.slide;
  const double q = row.grip_w[2] * limit.twist * limit.twist;
  // The bound's own multiplier, by Newton's iteration on 1 / use - 1, which is nearly straight.
  const double a = m_slide * slide * limit.slide;
  const double b = row.grip_w[2] * std::abs(row.twist) * limit.twist;
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

Vec3 rub(ContactRow& row, const Vec3& slip) {
  const std::array<double, 2> slide = row.slide;
  const double twist = row.twist;
  const double scale = 1.0 / determinant(row);
  row.slide[0] -= scale * (row.grip[2] * slip[0] - row.grip[1] * slip[1]);
  row.slide[1] -= scale * (row.grip[0] * slip[1] - row.grip[1] * slip[0]);
  if (row.twists()) row.twist -= slip[2] / row.grip_w[2];
  keep_within(row, friction_limit(row));
  return {row.slide[0] - slide[0], row.slide[1] - slide[1], row.twist - twist};
}

}  // namespace tandem::pbd
