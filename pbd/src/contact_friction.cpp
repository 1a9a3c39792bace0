// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_friction.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// How far friction reaches for the load that the normals carry.
struct FrictionLimit {
  double slide = 0.0;  ///< N s
  double twist = 0.0;  ///< N m s; the load's spread about its centre turns it into a moment
};

FrictionLimit friction_limit(const ContactRow& row) {
  FrictionLimit limit;
  for (int i = 0; i < row.count; ++i) {
    limit.slide += row.impulse[i];
    limit.twist += row.impulse[i] * row.lever[i];
  }
  limit.slide *= row.friction;
  limit.twist *= row.friction;
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
  const bool twists = row.twist_mass > 0.0 && limit.twist > 0.0;
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
  const double k_slide = 2.0 / (row.k00 + row.k11);
  const double p = k_slide * limit.slide * limit.slide;
  const double q = limit.twist * limit.twist / row.twist_mass;
  // The bound's own multiplier, by Newton's iteration on 1 / use - 1, which is nearly straight.
  const double a = k_slide * slide * limit.slide;
  const double b = std::abs(row.twist) * limit.twist / row.twist_mass;
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

void prepare_friction(const Contact& contact, const ContactArms& arms, const SolverBody& a,
                      const SolverBody& b, ContactRow& row) {
  const Manifold& m = contact.manifold;
  tangent_frame(m.normal, row.tangent[0], row.tangent[1]);
  std::array<double, 4> weight = contact.force;
  double total = weight[0] + weight[1] + weight[2] + weight[3];
  if (!(total > 0.0)) {
    weight = {1.0, 1.0, 1.0, 1.0};
    total = m.count;
  }
  Vec3 centre_a = Vec3::Zero();
  Vec3 centre_b = Vec3::Zero();
  for (int i = 0; i < m.count; ++i) {
    centre_a += weight[i] * arms.a[i];
    centre_b += weight[i] * arms.b[i];
  }
  centre_a /= total;
  centre_b /= total;
  std::array<Vec3, 2> response_a, response_b;
  for (int k = 0; k < 2; ++k) {
    row.rt_a[k] = centre_a.cross(row.tangent[k]);
    row.rt_b[k] = centre_b.cross(row.tangent[k]);
    response_a[k] = a.inv_inertia_w * row.rt_a[k];
    response_b[k] = b.inv_inertia_w * row.rt_b[k];
  }
  const double linear = a.inv_mass + b.inv_mass;
  const double w00 = linear + row.rt_a[0].dot(response_a[0]) + row.rt_b[0].dot(response_b[0]);
  const double w01 = row.rt_a[0].dot(response_a[1]) + row.rt_b[0].dot(response_b[1]);
  const double w11 = linear + row.rt_a[1].dot(response_a[1]) + row.rt_b[1].dot(response_b[1]);
  const double inverse_determinant = 1.0 / (w00 * w11 - w01 * w01);
  row.k00 = w11 * inverse_determinant;
  row.k01 = -w01 * inverse_determinant;
  row.k11 = w00 * inverse_determinant;
  const double w = m.normal.dot((a.inv_inertia_w + b.inv_inertia_w) * m.normal);
  row.twist_mass = m.count > 1 && w > 0.0 ? 1.0 / w : 0.0;
  for (int i = 0; i < m.count; ++i) {
    const Vec3 r = arms.b[i] - centre_b;
    row.lever[i] = (r - r.dot(m.normal) * m.normal).norm();
  }
}

void rub(ContactRow& row, SolverBody& a, SolverBody& b) {
  const Vec3 dv = b.v - a.v;
  const double slip_0 = row.tangent[0].dot(dv) + row.rt_b[0].dot(b.w) - row.rt_a[0].dot(a.w);
  const double slip_1 = row.tangent[1].dot(dv) + row.rt_b[1].dot(b.w) - row.rt_a[1].dot(a.w);
  const std::array<double, 2> slide = row.slide;
  const double twist = row.twist;
  row.slide[0] -= row.k00 * slip_0 + row.k01 * slip_1;
  row.slide[1] -= row.k01 * slip_0 + row.k11 * slip_1;
  if (row.twist_mass > 0.0) row.twist -= row.twist_mass * row.normal.dot(b.w - a.w);
  keep_within(row, friction_limit(row));
  apply_friction(row, {row.slide[0] - slide[0], row.slide[1] - slide[1]}, row.twist - twist, a, b);
}

void apply_friction(const ContactRow& row, const std::array<double, 2>& slide, double twist,
                    SolverBody& a, SolverBody& b) {
  const Vec3 p = slide[0] * row.tangent[0] + slide[1] * row.tangent[1];
  const Vec3 turn = twist * row.normal;
  if (a.inv_mass > 0.0) {
    a.v -= a.inv_mass * p;
    a.w -= a.inv_inertia_w * (slide[0] * row.rt_a[0] + slide[1] * row.rt_a[1] + turn);
  }
  if (b.inv_mass > 0.0) {
    b.v += b.inv_mass * p;
    b.w += b.inv_inertia_w * (slide[0] * row.rt_b[0] + slide[1] * row.rt_b[1] + turn);
  }
}

}  // namespace tandem::pbd
