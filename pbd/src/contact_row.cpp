// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_row.h"

#include <algorithm>
#include <cmath>

#include "contact_friction.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Sweeps of the inner solve of one manifold; it stops earlier where it has converged.
constexpr int kInnerSweeps = 6;
/// Relative change below which it has.
constexpr double kInnerTolerance = 1e-3;

double cross_component(const Vec3& n, const Vec3& a, const Vec3& b) { return n.dot(a.cross(b)); }

/// The combination u of four coplanar points with sum(u) = 0 and sum(u_i p_i) = 0, of unit length;
/// zeros for fewer points. u_i is the area of the triangle of the other three, signs alternating.
std::array<double, 4> idle_combination(const ContactArms& arms, int count, const Vec3& normal) {
  std::array<double, 4> u{};
  if (count != 4) return u;
  const auto area = [&](int i, int j, int k) {
    return cross_component(normal, arms.b[j] - arms.b[i], arms.b[k] - arms.b[i]);
  };
  u = {area(1, 2, 3), -area(0, 2, 3), area(0, 1, 3), -area(0, 1, 2)};
  double norm2 = 0.0;
  for (const double value : u) norm2 += value * value;
  const double scale = norm2 > 0.0 ? 1.0 / std::sqrt(norm2) : 0.0;
  for (double& value : u) value *= scale;
  return u;
}

/// Apply normal impulses `dz` to both bodies' `linear` and `angular` velocities.
void apply_normals(const ContactRow& row, const std::array<double, 4>& dz, SolverBody& a,
                   SolverBody& b, Vec3 SolverBody::*linear, Vec3 SolverBody::*angular) {
  double sum = 0.0;
  Vec3 moment_a = Vec3::Zero();
  Vec3 moment_b = Vec3::Zero();
  for (int i = 0; i < row.count; ++i) {
    sum += dz[i];
    moment_a += dz[i] * row.rn_a[i];
    moment_b += dz[i] * row.rn_b[i];
  }
  if (a.inv_mass > 0.0) {
    a.*linear -= a.inv_mass * sum * row.normal;
    a.*angular -= a.inv_inertia_w * moment_a;
  }
  if (b.inv_mass > 0.0) {
    b.*linear += b.inv_mass * sum * row.normal;
    b.*angular += b.inv_inertia_w * moment_b;
  }
}

/// Solve  0 <= z  _|_  e + B (z - z_0) >= 0  by projected Gauss-Seidel, B the mobility, z_0 the
/// values of `z` on entry and e the velocities there. Adds the changes to `dz`. Returns the largest
/// change of a velocity in the first sweep, m/s.
double solve_points(const ContactRow& row, std::array<double, 4>& z, std::array<double, 4>& e,
                    std::array<double, 4>& dz) {
  const int n = row.count;
  double first = 0.0;
  for (int sweep = 0; sweep < kInnerSweeps; ++sweep) {
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
      const double change = std::max(-z[i], -e[i] * row.mass[i]);
      z[i] += change;
      dz[i] += change;
      for (int j = 0; j < n; ++j) e[j] += row.mobility[i][j] * change;
      largest = std::max(largest, std::abs(change) * row.mobility[i][i]);
    }
    if (sweep == 0) first = largest;
    if (n == 1 || largest <= kInnerTolerance * first) break;
  }
  return first;
}

/// Speed (m/s) after a bounce off a gap (m) that closes within the substep: restitution e is the
/// ratio of energies, e^2, of what semi-implicit Euler conserves in free fall,
/// v^2 / 2 + a x - a h v / 2, so that the height of a bounce does not depend on h.
double bounce_of(double e, double approach, double gap, double a, double h) {
  const double energy2 = approach * approach + 2.0 * a * gap + a * h * approach;
  return 0.5 * a * h + std::sqrt(0.25 * a * a * h * h + e * e * energy2);
}

double normal_velocity(const ContactRow& row, const SolverBody& a, const SolverBody& b, int i) {
  return row.normal.dot(b.v - a.v) + row.rn_b[i].dot(b.w) - row.rn_a[i].dot(a.w);
}

}  // namespace

double gap_of(const Manifold& m, const SolverBody& a, const SolverBody& b, int i) {
  const Vec3 p_a = a.x + a.q * m.points[i].anchor_a_l;
  const Vec3 p_b = b.x + b.q * m.points[i].anchor_b_l;
  return m.normal.dot(p_b - p_a) - m.radius_a - m.radius_b;
}

ContactArms arms_of(const Manifold& m, const SolverBody& a, const SolverBody& b) {
  // Half-way between the two anchors, or below the centre of the one that is round, which its
  // normal must not turn (a ball would speed up as it rolls).
  const bool round_a = m.radius_a > 0.0;
  const bool round_b = m.radius_b > 0.0;
  const double share_b = round_a == round_b ? 0.5 : (round_b ? 1.0 : 0.0);
  ContactArms arms;
  const Vec3 between = b.x - a.x;
  for (int i = 0; i < m.count; ++i) {
    const Vec3 r_a = a.q * m.points[i].anchor_a_l + m.radius_a * m.normal;
    const Vec3 r_b = b.q * m.points[i].anchor_b_l - m.radius_b * m.normal;
    arms.a[i] = r_a + share_b * (between + r_b - r_a);
    arms.b[i] = arms.a[i] - between;
  }
  return arms;
}

void prepare_row(const Contact& contact, std::span<const SolverBody> bodies,
                 const ContactOptions& options, ContactRow& row) {
  const Manifold& m = contact.manifold;
  row.a = m.body_a;
  row.b = m.body_b;
  row.count = static_cast<std::uint8_t>(m.count);
  row.normal = m.normal;
  row.friction = m.friction;
  row.rubs = m.friction > 0.0;
  const SolverBody& a = bodies[row.a];
  const SolverBody& b = bodies[row.b];
  row.movable = a.inv_mass > 0.0 ? row.a : row.b;
  row.impulse = {};
  row.slide = {};
  row.twist = 0.0;
  const ContactArms arms = arms_of(m, a, b);
  std::array<Vec3, 4> response_a, response_b;
  for (int i = 0; i < m.count; ++i) {
    row.rn_a[i] = arms.a[i].cross(m.normal);
    row.rn_b[i] = arms.b[i].cross(m.normal);
    response_a[i] = a.inv_inertia_w * row.rn_a[i];
    response_b[i] = b.inv_inertia_w * row.rn_b[i];
  }
  const double linear = a.inv_mass + b.inv_mass;
  double trace = 0.0;
  for (int i = 0; i < m.count; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double value = linear + row.rn_a[i].dot(response_a[j]) + row.rn_b[i].dot(response_b[j]);
      row.mobility[i][j] = value;
      row.mobility[j][i] = value;
    }
    trace += row.mobility[i][i];
  }
  row.idle = idle_combination(arms, m.count, m.normal);
  if (m.count == 4) {
    const double scale = std::sqrt(options.evenness * trace);
    for (double& value : row.idle) value *= scale;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) row.mobility[i][j] += row.idle[i] * row.idle[j];
    }
  }
  for (int i = 0; i < m.count; ++i) {
    row.mass[i] = row.mobility[i][i] > 0.0 ? 1.0 / row.mobility[i][i] : 0.0;
  }
  if (row.rubs) prepare_friction(contact, arms, a, b, row);
}

void begin_row(const Contact& contact, const SubstepRule& rule, double h,
               std::span<const SolverBody> bodies, ContactRow& row) {
  const Manifold& m = contact.manifold;
  const SolverBody& a = bodies[row.a];
  const SolverBody& b = bodies[row.b];
  // One rotation of the normal serves all points.
  const Vec3 n_a = a.q.conjugate() * m.normal;
  const Vec3 n_b = b.q.conjugate() * m.normal;
  const double apart = m.normal.dot(b.x - a.x) - m.radius_a - m.radius_b;
  // m/s^2, how gravity adds to the approach of the two
  const double fall =
      std::max(0.0, (a.gravity_scale - b.gravity_scale) * m.normal.dot(rule.gravity));
  row.approach = 0.0;
  row.sunk = false;
  for (int i = 0; i < m.count; ++i) {
    const double gap =
        apart + n_b.dot(m.points[i].anchor_b_l) - n_a.dot(m.points[i].anchor_a_l) - contact.debt[i];
    row.bias[i] = gap > 0.0 ? gap / h : std::max(rule.push_gain * gap / h, -rule.push_speed);
    row.sunk = row.sunk || gap < -rule.push_slop;
    if (gap >= rule.warm_start_gap) row.impulse[i] = 0.0;
    const double approach = -normal_velocity(row, a, b, i);
    row.approach = std::max(row.approach, approach);
    row.bounce[i] = m.restitution > 0.0 && approach > rule.bounce_speed
                        ? bounce_of(m.restitution, approach, std::max(gap, 0.0), fall, h)
                        : 0.0;
  }
  if (row.loaded()) return;
  row.slide = {};
  row.twist = 0.0;
}

void apply_impulses(const ContactRow& row, const RowImpulses& impulses,
                    std::span<SolverBody> bodies) {
  SolverBody& a = bodies[row.a];
  SolverBody& b = bodies[row.b];
  apply_normals(row, impulses.normal, a, b, &SolverBody::v, &SolverBody::w);
  if (row.rubs) apply_friction(row, impulses.slide, impulses.twist, a, b);
}

double solve_row(ContactRow& row, ContactPass pass, std::span<SolverBody> bodies) {
  SolverBody& a = bodies[row.a];
  SolverBody& b = bodies[row.b];
  std::array<double, 4> e;
  bool active = false;
  for (int i = 0; i < row.count; ++i) {
    // In the velocity pass a point that carries nothing may still close what is left of its gap.
    const bool closing = pass == ContactPass::Motion || row.impulse[i] <= 0.0;
    e[i] = normal_velocity(row, a, b, i) + (closing && row.bias[i] > 0.0 ? row.bias[i] : 0.0) -
           (pass == ContactPass::Velocity ? row.bounce[i] : 0.0);
    active = active || e[i] < 0.0 || row.impulse[i] > 0.0;
  }
  if (!active) return 0.0;
  if (row.count == 4) {
    double idle = 0.0;
    for (int i = 0; i < 4; ++i) idle += row.idle[i] * row.impulse[i];
    for (int i = 0; i < 4; ++i) e[i] += row.idle[i] * idle;
  }
  std::array<double, 4> dz{};
  const double change = solve_points(row, row.impulse, e, dz);
  if (change > 0.0) apply_normals(row, dz, a, b, &SolverBody::v, &SolverBody::w);
  if (row.rubs) rub(row, a, b);
  return change;
}

bool push_row(const ContactRow& row, std::span<SolverBody> bodies) {
  SolverBody& a = bodies[row.a];
  SolverBody& b = bodies[row.b];
  const bool disturbed = !a.v_push.isZero(0.0) || !b.v_push.isZero(0.0);
  if (!row.sunk && !disturbed) return false;
  std::array<double, 4> e;
  bool active = false;
  for (int i = 0; i < row.count; ++i) {
    e[i] = row.normal.dot(b.v_push - a.v_push) + row.rn_b[i].dot(b.w_push) -
           row.rn_a[i].dot(a.w_push) + row.bias[i];
    active = active || e[i] < 0.0;
  }
  if (!active) return false;
  std::array<double, 4> z{};
  std::array<double, 4> dz{};
  solve_points(row, z, e, dz);
  apply_normals(row, dz, a, b, &SolverBody::v_push, &SolverBody::w_push);
  return true;
}

}  // namespace tandem::pbd
