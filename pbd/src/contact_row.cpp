// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_row.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

double cross_component(const Vec3& n, const Vec3& a, const Vec3& b) { return n.dot(a.cross(b)); }

/// The combination u of four coplanar points with sum(u) = 0 and sum(u_i p_i) = 0, of unit length.
/// u_i is the area of the triangle of the other three, signs alternating.
std::array<double, 4> self_stress_of(const ContactArms& arms, const Vec3& normal) {
  const auto area = [&](std::size_t i, std::size_t j, std::size_t k) {
    return cross_component(normal, arms.b[j] - arms.b[i], arms.b[k] - arms.b[i]);
  };
  std::array<double, 4> u{area(1, 2, 3), -area(0, 2, 3), area(0, 1, 3), -area(0, 1, 2)};
  const double norm = std::sqrt((u[0] * u[0] + u[1] * u[1]) + (u[2] * u[2] + u[3] * u[3]));
  for (double& each : u) each = norm > 0.0 ? each / norm : 0.0;
  return u;
}

void set_bit(LaneMask& mask, std::size_t lane, bool value) {
  mask = static_cast<LaneMask>((mask & ~(1u << lane)) | (unsigned{value} << lane));
}

void set_vector(LaneArray<3>& lanes, std::size_t lane, const Vec3& value) {
  for (std::size_t k = 0; k < 3; ++k) lanes[k][lane] = value[static_cast<Eigen::Index>(k)];
}

/// Lanes from `count` on repeat the first one.
void repeat_first_of(std::size_t count, Lanes& lanes) {
  for (std::size_t lane = count; lane < kLanes; ++lane) lanes[lane] = lanes[0];
}
template <std::size_t n>
void repeat_first_of(std::size_t count, LaneArray<n>& array) {
  for (Lanes& lanes : array) repeat_first_of(count, lanes);
}
template <class... Members>
void repeat_first(std::size_t count, Members&... members) {
  (repeat_first_of(count, members), ...);
}

/// m, world, from the centre of mass. The anchor of a ball is its centre, which does not turn.
[[gnu::always_inline]] inline Vec3 anchor_of(const SolverBody& body, const Vec3& anchor_l) {
  const bool turns = anchor_l.x() != 0.0 || anchor_l.y() != 0.0 || anchor_l.z() != 0.0;
  return turns ? rotate(body.q, anchor_l) : anchor_l;
}

/// Implementation of set_arms().
/// @param t1, t2  of tangent_frame()
void place_arms(const Contact& contact, std::span<const SolverBody> bodies, const Vec3& t1,
                const Vec3& t2, ContactRows& rows, std::size_t lane) {
  const Manifold& m = contact.manifold;
  const ContactArms arms = arms_of(m, bodies[m.body_a], bodies[m.body_b]);
  // Friction acts at the centre of pressure of the carried forces.
  const auto& f = contact.force;
  const double total = (f[0] + f[1]) + (f[2] + f[3]);
  Vec3 arm_a = Vec3::Zero();
  Vec3 arm_b = Vec3::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(m.count); ++i) {
    const double weight = total > 0.0 ? f[i] / total : 1.0 / m.count;
    arm_a += weight * arms.a[i];
    arm_b += weight * arms.b[i];
  }
  set_vector(rows.arm_a, lane, arm_a);
  set_vector(rows.arm_b, lane, arm_b);
  if (!rows.faces) return;
  const std::array<double, 4> self_stress =
      m.count == 4 ? self_stress_of(arms, m.normal) : std::array<double, 4>{};
  for (std::size_t i = 0; i < 4; ++i) {
    const bool there = i < static_cast<std::size_t>(m.count);
    const Vec3 from_centre = there ? Vec3(arms.a[i] - arm_a) : Vec3(Vec3::Zero());
    const double s = t2.dot(from_centre);
    const double r = -t1.dot(from_centre);
    rows.s[i][lane] = s;
    rows.r[i][lane] = r;
    rows.reach[i][lane] = std::sqrt(s * s + r * r);
    rows.self_stress[i][lane] = self_stress[i];
  }
}

}  // namespace

BodyNumbers numbers_of(std::span<SolverBody> bodies) {
  constexpr std::size_t kApplied = offsetof(SolverBody, v_applied);
  static_assert(offsetof(SolverBody, x) == BodyNumbers::kX * sizeof(double) &&
                offsetof(SolverBody, q) == BodyNumbers::kQ * sizeof(double));
  static_assert(offsetof(SolverBody, v) == 0 && offsetof(SolverBody, w) == 3 * sizeof(double) &&
                offsetof(SolverBody, inv_mass) == 6 * sizeof(double) &&
                offsetof(SolverBody, inv_inertia_w) == 7 * sizeof(double) &&
                offsetof(SolverBody, w_applied) == kApplied + 3 * sizeof(double) &&
                offsetof(SolverBody, v_push) == kApplied + 6 * sizeof(double) &&
                offsetof(SolverBody, w_push) == kApplied + 9 * sizeof(double));
  return {.first = bodies.empty() ? nullptr : bodies.front().v.data(),
          .stride = sizeof(SolverBody) / sizeof(double),
          .applied = kApplied / sizeof(double)};
}

AnchorNumbers anchors_of(std::span<const Contact> contacts) {
  constexpr std::size_t kNumber = sizeof(double);
  static_assert(sizeof(ManifoldPoint) == AnchorNumbers::kPoint * kNumber &&
                offsetof(ManifoldPoint, anchor_a_l) == 0 &&
                offsetof(ManifoldPoint, anchor_b_l) == 3 * kNumber &&
                sizeof(Contact) % kNumber == 0);
  if (contacts.empty()) return {};
  return {.first = contacts[0].manifold.points[0].anchor_a_l.data(),
          .stride = sizeof(Contact) / kNumber};
}

double gap_of(const Manifold& m, const SolverBody& a, const SolverBody& b, int i) {
  const Vec3 arm_a = anchor_of(a, m.points[i].anchor_a_l);
  const Vec3 arm_b = anchor_of(b, m.points[i].anchor_b_l);
  // Scalar code: reading pairs of numbers that were written singly stalls store forwarding.
  const auto apart = [&](int k) {
    return m.normal[k] * ((b.x[k] + arm_b[k]) - (a.x[k] + arm_a[k]));
  };
  return ((apart(0) + apart(1)) + apart(2)) - m.radius_a - m.radius_b;
}

ContactArms arms_of(const Manifold& m, const SolverBody& a, const SolverBody& b) {
  // Half-way between the two anchors, or below the centre of the round one, which its normal must
  // not turn (a ball would speed up as it rolls).
  const bool round_a = m.radius_a > 0.0;
  const bool round_b = m.radius_b > 0.0;
  const double share_b = round_a == round_b ? 0.5 : (round_b ? 1.0 : 0.0);
  ContactArms arms;
  for (int i = 0; i < m.count; ++i) {
    const Vec3 anchor_a = anchor_of(a, m.points[i].anchor_a_l);
    const Vec3 anchor_b = anchor_of(b, m.points[i].anchor_b_l);
    for (int k = 0; k < 3; ++k) {  // as in gap_of()
      const double between = b.x[k] - a.x[k];
      const double r_a = anchor_a[k] + m.radius_a * m.normal[k];
      const double r_b = anchor_b[k] - m.radius_b * m.normal[k];
      arms.gap[i] += m.normal[k] * (between + r_b - r_a);
      arms.a[i][k] = r_a + share_b * (between + r_b - r_a);
      arms.b[i][k] = arms.a[i][k] - between;
    }
  }
  return arms;
}

void set_row(const Contact& contact, std::span<const SolverBody> bodies, const Vec3& gravity,
             ContactRows& rows, std::size_t lane) {
  const Manifold& m = contact.manifold;
  const SolverBody& a = bodies[m.body_a];
  const SolverBody& b = bodies[m.body_b];
  rows.a[lane] = m.body_a;
  rows.b[lane] = m.body_b;
  set_bit(rows.a_moves, lane, a.inv_mass > 0.0);
  set_bit(rows.b_moves, lane, b.inv_mass > 0.0);
  Vec3 t1;
  Vec3 t2;
  tangent_frame(m.normal, t1, t2);
  set_vector(rows.normal, lane, m.normal);
  set_vector(rows.t1, lane, t1);
  rows.carried[lane] = contact.warm_start_scale;
  rows.friction[lane] = m.friction;
  rows.restitution[lane] = m.restitution;
  rows.radii[lane] = m.radius_a + m.radius_b;
  rows.fall[lane] = std::max(0.0, (a.gravity_scale - b.gravity_scale) * m.normal.dot(gravity));
  for (std::size_t i = 0; i < rows.most_points(); ++i) {
    rows.impulse[i][lane] = contact.force[i];
  }
  rows.slide[0][lane] = contact.carried_friction.dot(t1);
  rows.slide[1][lane] = contact.carried_friction.dot(t2);
  rows.twist[lane] = contact.carried_twist;
  rows.points[lane] = m.count;
  place_arms(contact, bodies, t1, t2, rows, lane);
}

void set_arms(const Contact& contact, std::span<const SolverBody> bodies, ContactRows& rows,
              std::size_t lane) {
  Vec3 t1;
  Vec3 t2;
  tangent_frame(contact.manifold.normal, t1, t2);
  place_arms(contact, bodies, t1, t2, rows, lane);
}

void repeat_first_row(ContactRows& rows) {
  for (std::size_t lane = rows.count; lane < kLanes; ++lane) {
    rows.a[lane] = rows.a[0];
    rows.b[lane] = rows.b[0];
    rows.contact[lane] = rows.contact[0];
  }
  repeat_first(rows.count, rows.friction, rows.points, rows.normal, rows.t1, rows.arm_a, rows.arm_b,
               rows.slide, rows.impulse, rows.carried, rows.radii, rows.restitution, rows.fall);
  if (rows.faces)
    repeat_first(rows.count, rows.s, rows.r, rows.reach, rows.self_stress, rows.twist);
}

Vec3 friction_of(const ContactRows& rows, std::size_t lane) {
  const auto along = [&](std::size_t k) {  // as in gap_of()
    const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
    const double t2 =
        rows.normal[l][lane] * rows.t1[m][lane] - rows.normal[m][lane] * rows.t1[l][lane];
    return rows.slide[0][lane] * rows.t1[k][lane] + rows.slide[1][lane] * t2;
  };
  return {along(0), along(1), along(2)};
}

double warm_start_scale(const ContactRows& rows, std::size_t lane, double growth) {
  const double load = rows.load(lane);
  const double most = kGrowth * rows.carried[lane] + growth / rows.k_nn[lane];
  return load > most ? most / load : 1.0;
}

namespace {

/// How far a carried impulse may turn a body with joints (rad), or shift it (in radii of gyration),
/// before joints act. In eight turns of joints and contacts the ground takes from one hand the
/// impulse that stops a whole falling ragdoll; carried on whole, it turns the hand by radians,
/// beyond the range of the gradients: 2 of 400 ragdolls came to 1e6 times their energy; with 0.2
/// and with 1 none does.
constexpr double kNear = 0.5;

/// Motion of a body by an impulse (N s) of a lane in the substep, in the measure of kNear.
double way_of(const SolverBody& body, const Vec3& arm, const Vec3& impulse, double h) {
  const double turn = h * (body.inv_inertia_w * arm.cross(impulse)).norm();
  const double slowest = body.inv_inertia_w.diagonal().minCoeff();
  return std::max(turn, h * impulse.norm() * std::sqrt(body.inv_mass * slowest));
}

}  // namespace

void carry_near(ContactRows& rows, const SubstepContext& ctx) {
  const auto vector = [](const LaneArray<3>& lanes, std::size_t lane) {
    return Vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
  };
  for (std::size_t lane = 0; lane < rows.count; ++lane) {
    if ((rows.joined >> lane & 1u) == 0) continue;
    const Vec3 impulse = rows.load(lane) * vector(rows.normal, lane);
    double way = 0.0;
    const SolverBody& a = ctx.bodies[rows.a[lane]];
    const SolverBody& b = ctx.bodies[rows.b[lane]];
    if (a.projected) way = way_of(a, vector(rows.arm_a, lane), impulse, ctx.h);
    if (b.projected) way = std::max(way, way_of(b, vector(rows.arm_b, lane), impulse, ctx.h));
    if (!(way > kNear)) continue;
    const double share = kNear / way;
    for (Lanes& each : rows.impulse) each[lane] *= share;
    for (Lanes& each : rows.slide) each[lane] *= share;
    rows.twist[lane] *= share;
    rows.carried[lane] *= share;
  }
}

}  // namespace tandem::pbd
