// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_row.h"

#include <algorithm>
#include <cmath>

#include "contact_friction.h"
#include "contact_lcp.h"
#include "contact_motion.h"
#include "contact_point.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Carried impulses grow by this factor in a substep at most, beyond what holds a body that weighs
/// as much as the contact's effective mass, in this gravity at least (m/s^2).
constexpr double kGrowth = 2.0;
constexpr double kLeastGravity = 1.0;

/// How often a row's normals and friction take turns where friction starts anew: left half-way,
/// what stands on a slope would creep. Elsewhere once is enough.
constexpr int kTurns = 3;

double cross_component(const Vec3& n, const Vec3& a, const Vec3& b) { return n.dot(a.cross(b)); }

/// The combination u of four coplanar points with sum(u) = 0 and sum(u_i p_i) = 0, of unit length.
/// u_i is the area of the triangle of the other three, signs alternating.
Four idle_combination(const ContactArms& arms, const Vec3& normal) {
  const auto area = [&](int i, int j, int k) {
    return cross_component(normal, arms.b[j] - arms.b[i], arms.b[k] - arms.b[i]);
  };
  const Four u(area(1, 2, 3), -area(0, 2, 3), area(0, 1, 3), -area(0, 1, 2));
  const double norm = std::sqrt(sum(u.square()));
  return norm > 0.0 ? Four(u / norm) : Four(Four::Zero());
}

/// Where friction acts: the centre of pressure of the carried forces, as weights of the points; all
/// alike where there are none.
Four pressure_weights(const Contact& contact) {
  const Four weight(contact.force[0], contact.force[1], contact.force[2], contact.force[3]);
  const double total = sum(weight);
  if (total > 0.0) return weight / total;
  return Four::Constant(1.0 / contact.manifold.count);
}

/// Add a body's share of the responses at the end of its arm, in the contact's axes.
void add_response(const SolverBody& body, const Vec3& arm, const Mat3& axes, ContactRow& row) {
  const Mat3 inertia = axes.transpose() * body.inv_inertia_w * axes;
  const Mat3 lever = skew(axes.transpose() * arm);
  const Mat3 spin = inertia * lever;           // W per force
  const Mat3 move = lever.transpose() * spin;  // V per force, beside inv_mass
  row.press_n += body.inv_mass + move(0, 0);
  row.slip_n[0] += move(1, 0);
  row.slip_n[1] += move(2, 0);
  row.grip[0] += body.inv_mass + move(1, 1);
  row.grip[1] += move(1, 2);
  row.grip[2] += body.inv_mass + move(2, 2);
  if (row.count == 1) return;
  row.press_w[0] += spin(1, 0);
  row.press_w[1] += spin(2, 0);
  row.press_w[2] += inertia(1, 1);
  row.press_w[3] += inertia(1, 2);
  row.press_w[4] += inertia(2, 2);
  row.slip_w[0] += spin(1, 1);
  row.slip_w[1] += spin(2, 1);
  row.slip_w[2] += spin(1, 2);
  row.slip_w[3] += spin(2, 2);
  row.slip_w[4] += spin(0, 0);
  row.slip_w[5] += inertia(0, 1);
  row.slip_w[6] += inertia(0, 2);
  row.grip_w[0] += spin(0, 1);
  row.grip_w[1] += spin(0, 2);
  row.grip_w[2] += inertia(0, 0);
}

/// Response of the points' normal velocities to their impulses, idle combination included, 1/kg.
FourByFour mobility_of(const ContactRow& row) {
  const double nn = row.press_n;
  const auto& [n1, n2, m11, m12, m22] = row.press_w;
  // Responses of V_n, W_1 and W_2 to a unit impulse at each point.
  const Four v = nn + n1 * row.s + n2 * row.r;
  const Four w1 = n1 + m11 * row.s + m12 * row.r;
  const Four w2 = n2 + m12 * row.s + m22 * row.r;
  FourByFour B;
  for (int j = 0; j < 4; ++j) {
    B.col(j) = v[j] + row.s * w1[j] + row.r * w2[j] + row.idle * row.idle[j];
  }
  return B;
}

/// Velocities of the points along the normal, m/s.
Four normal_velocities(const ContactRow& row, const Vec3& t2, const RelativeMotion& motion) {
  const double v = row.normal.dot(motion.v);
  const double w1 = row.t1.dot(motion.w);
  const double w2 = t2.dot(motion.w);
  return v + w1 * row.s + w2 * row.r;
}

/// What the points' impulses add up to: F_n, T_1, T_2.
Vec3 press_of(const ContactRow& row, const Four& z) {
  return {sum(z), sum(row.s * z), sum(row.r * z)};
}

/// What friction's impulses (F_1, F_2, T_n) do to V_1, V_2 and W_n.
Vec3 gripped(const ContactRow& row, const Vec3& f) {
  const auto& [m11, m12, m22] = row.grip;
  const auto& [m1n, m2n, mnn] = row.grip_w;
  return {m11 * f[0] + m12 * f[1] + m1n * f[2], m12 * f[0] + m22 * f[1] + m2n * f[2],
          m1n * f[0] + m2n * f[1] + mnn * f[2]};
}

/// Change both bodies' `linear` and `angular` velocities.
void apply_wrench(const ContactRow& row, const Vec3& t2, const ContactWrench& wrench, SolverBody& a,
                  SolverBody& b, Vec3 SolverBody::*linear, Vec3 SolverBody::*angular) {
  const auto to_world = [&](const Vec3& p) -> Vec3 {
    return p[0] * row.normal + p[1] * row.t1 + p[2] * t2;
  };
  apply_wrench(row, to_world(wrench.force), to_world(wrench.couple), a, b, linear, angular);
}

/// The fastest change of a normal velocity that the points ask for, m/s: how far they are from
/// 0 <= z _|_ e >= 0.
double disagreement(const ContactRow& row, const FourByFour& B, const Four& e) {
  double largest = 0.0;
  for (int i = 0; i < row.count; ++i) {
    largest = std::max(largest, std::abs(std::min(e[i], B(i, i) * row.impulse[i])));
  }
  return largest;
}

/// Speed (m/s) after a bounce off a gap (m) that closes within the substep: restitution e is the
/// ratio of energies, e^2, of what semi-implicit Euler conserves in free fall,
/// v^2 / 2 + a x - a h v / 2, so that the height of a bounce does not depend on h.
double bounce_of(double e, double approach, double gap, double a, double h) {
  const double energy2 = approach * approach + 2.0 * a * gap + a * h * approach;
  return 0.5 * a * h + std::sqrt(0.25 * a * a * h * h + e * e * energy2);
}

/// push_row(), of a row that is sunk or whose bodies were pushed.
bool push_face(const ContactRow& row, SolverBody& a, SolverBody& b) {
  const Vec3 t2 = row.t2();
  const RelativeMotion motion{
      b.v_push - a.v_push + b.w_push.cross(row.arm_b) - a.w_push.cross(row.arm_a),
      b.w_push - a.w_push};
  const Four e = normal_velocities(row, t2, motion) + row.bias;
  bool active = false;
  for (int i = 0; i < row.count; ++i) {
    active = active || e[i] < 0.0;
  }
  if (!active) return false;
  const Four dz = solve_lcp(row.count, mobility_of(row), Four::Zero(), e);
  const Vec3 press = press_of(row, dz);
  apply_wrench(row, t2, {.force = {press[0], 0.0, 0.0}, .couple = {0.0, press[1], press[2]}}, a, b,
               &SolverBody::v_push, &SolverBody::w_push);
  return true;
}

/// push_row(), where the body below has to count as heavier: by `share` of its inverse mass.
bool push_from_below(const ContactRow& row, double share, SolverBody& a, SolverBody& b) {
  SolverBody& below = row.a_below ? a : b;
  SolverBody heavier = below;
  heavier.inv_mass *= share;
  heavier.inv_inertia_w *= share;
  SolverBody& one = row.a_below ? heavier : a;
  SolverBody& other = row.a_below ? b : heavier;
  ContactRow scaled = row;
  scaled.press_n = 0.0;
  scaled.press_w = {};
  Mat3 axes;
  axes << row.normal, row.t1, row.t2();
  add_response(one, row.arm_a, axes, scaled);
  add_response(other, row.arm_b, axes, scaled);
  if (row.count == 1 ? !push_point(scaled, one, other) : !push_face(scaled, one, other)) {
    return false;
  }
  below.v_push = heavier.v_push;
  below.w_push = heavier.w_push;
  return true;
}

/// The share that makes the body below no lighter than the one above; 1 where it is not.
double share_of_lower(const ContactRow& row, const SolverBody& a, const SolverBody& b) {
  if (!row.a_below && !row.b_below) return 1.0;
  const double below = row.a_below ? a.inv_mass : b.inv_mass;
  const double above = row.a_below ? b.inv_mass : a.inv_mass;
  return below > above && above > 0.0 ? above / below : 1.0;
}

/// q * v with the same bits. Eigen's own writes its cross product number by number and reads it
/// back in pairs, for which the processor waits longer than for all the rest.
Vec3 turned(const Quat& q, const Vec3& v) {
  const double x = 2.0 * (q.y() * v.z() - q.z() * v.y());
  const double y = 2.0 * (q.z() * v.x() - q.x() * v.z());
  const double z = 2.0 * (q.x() * v.y() - q.y() * v.x());
  return {v.x() + q.w() * x + (q.y() * z - q.z() * y), v.y() + q.w() * y + (q.z() * x - q.x() * z),
          v.z() + q.w() * z + (q.x() * y - q.y() * x)};
}

/// m, world, from the centre of mass. Balls have theirs in the middle, which does not turn.
Vec3 anchor_of(const SolverBody& body, const Vec3& anchor_l) {
  return anchor_l.isZero(0.0) ? anchor_l : turned(body.q, anchor_l);
}

/// m, between two points (world) of which one is on each body.
double gap_between(const Manifold& m, const Vec3& p_a, const Vec3& p_b) {
  return m.normal.dot(p_b - p_a) - m.radius_a - m.radius_b;
}

}  // namespace

double gap_of(const Manifold& m, const SolverBody& a, const SolverBody& b, int i) {
  return gap_between(m, a.x + anchor_of(a, m.points[i].anchor_a_l),
                     b.x + anchor_of(b, m.points[i].anchor_b_l));
}

ContactArms arms_of(const Manifold& m, const SolverBody& a, const SolverBody& b,
                    std::array<double, 4>* gaps) {
  // Half-way between the two anchors, or below the centre of the one that is round, which its
  // normal must not turn (a ball would speed up as it rolls).
  const bool round_a = m.radius_a > 0.0;
  const bool round_b = m.radius_b > 0.0;
  const double share_b = round_a == round_b ? 0.5 : (round_b ? 1.0 : 0.0);
  ContactArms arms;
  const Vec3 between = b.x - a.x;
  for (int i = 0; i < m.count; ++i) {
    const Vec3 anchor_a = anchor_of(a, m.points[i].anchor_a_l);
    const Vec3 anchor_b = anchor_of(b, m.points[i].anchor_b_l);
    if (gaps != nullptr) (*gaps)[i] = gap_between(m, a.x + anchor_a, b.x + anchor_b);
    const Vec3 r_a = anchor_a + m.radius_a * m.normal;
    const Vec3 r_b = anchor_b - m.radius_b * m.normal;
    arms.a[i] = r_a + share_b * (between + r_b - r_a);
    arms.b[i] = arms.a[i] - between;
  }
  return arms;
}

void prepare_row(const Contact& contact, std::span<const SolverBody> bodies,
                 const ContactOptions& options, ContactRow& row) {
  const Manifold& m = contact.manifold;
  const SolverBody& a = bodies[m.body_a];
  const SolverBody& b = bodies[m.body_b];
  const std::uint32_t place = row.contact;
  row = {};
  row.contact = place;
  row.a = m.body_a;
  row.b = m.body_b;
  row.a_moves = a.inv_mass > 0.0;
  row.count = static_cast<std::uint8_t>(m.count);
  row.friction = m.friction;
  row.normal = m.normal;
  Vec3 t2;
  tangent_frame(row.normal, row.t1, t2);
  const ContactArms arms = arms_of(m, a, b);
  const Four weight = pressure_weights(contact);
  row.arm_a.setZero();
  row.arm_b.setZero();
  for (int i = 0; i < m.count; ++i) {
    row.arm_a += weight[i] * arms.a[i];
    row.arm_b += weight[i] * arms.b[i];
  }
  for (int i = 0; i < m.count && m.count > 1; ++i) {
    const Vec3 from_centre = arms.a[i] - row.arm_a;
    row.s[i] = t2.dot(from_centre);
    row.r[i] = -row.t1.dot(from_centre);
  }
  Mat3 axes;
  axes << row.normal, row.t1, t2;
  if (a.inv_mass > 0.0) add_response(a, row.arm_a, axes, row);
  if (b.inv_mass > 0.0) add_response(b, row.arm_b, axes, row);
  if (m.count < 4) return;
  const FourByFour B = mobility_of(row);
  row.idle =
      std::sqrt(options.evenness * sum(B.matrix().diagonal())) * idle_combination(arms, m.normal);
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
  const Four velocity = row.count == 1
                            ? Four(Four::Constant(row.normal.dot(relative_velocity(row, a, b))))
                            : normal_velocities(row, row.t2(), relative_motion(row, a, b));
  const double share = share_to_carry(row, rule.gravity.norm(), h);
  row.impulse *= share;
  row.slide[0] *= share;
  row.slide[1] *= share;
  if (row.count > 1) row.twist *= share;
  double fastest = 0.0;
  Four bounce = Four::Zero();
  row.sunk = false;
  row.bounces = false;
  for (int i = 0; i < m.count; ++i) {
    const double gap =
        apart + n_b.dot(m.points[i].anchor_b_l) - n_a.dot(m.points[i].anchor_a_l) - contact.debt[i];
    row.bias[i] = gap > 0.0 ? gap / h : std::max(rule.push_gain * gap / h, -rule.push_speed);
    row.sunk = row.sunk || gap < -rule.push_slop;
    if (gap >= rule.warm_start_gap) row.impulse[i] = 0.0;
    const double approach = -velocity[i];
    fastest = std::max(fastest, approach);
    if (m.restitution > 0.0 && approach > rule.bounce_speed) {
      row.bounces = true;
      bounce[i] = bounce_of(m.restitution, approach, std::max(gap, 0.0), fall, h);
    }
  }
  if (row.bounces) row.bounce = bounce;
  row.approach = static_cast<float>(fastest);
  row.carried = static_cast<float>(sum(row.impulse));
  if (row.loaded()) return;
  row.slide = {};
  if (row.count > 1) row.twist = 0.0;
}

double share_to_carry(const ContactRow& row, double gravity, double h) {
  const double load = sum(row.impulse);
  const double most = kGrowth * static_cast<double>(row.carried) +
                      std::max(gravity, kLeastGravity) * h / row.press_n;
  return load > most ? most / load : 1.0;
}

void warm_start_row(const ContactRow& row, std::span<SolverBody> bodies) {
  if (row.count == 1) return warm_start_point(row, bodies[row.a], bodies[row.b]);
  const Vec3 press = press_of(row, row.impulse);
  apply_wrench(
      row, row.t2(),
      {.force = {press[0], row.slide[0], row.slide[1]}, .couple = {row.twist, press[1], press[2]}},
      bodies[row.a], bodies[row.b], &SolverBody::v, &SolverBody::w);
}

double solve_row(ContactRow& row, ContactPass pass, bool fresh, std::span<SolverBody> bodies) {
  SolverBody& a = bodies[row.a];
  SolverBody& b = bodies[row.b];
  const int turns = fresh ? kTurns : 1;
  if (row.count == 1) return solve_point(row, pass, turns, a, b);
  const Vec3 t2 = row.t2();
  const RelativeMotion motion = relative_motion(row, a, b);
  Four e = normal_velocities(row, t2, motion);
  bool active = false;
  for (int i = 0; i < row.count; ++i) {
    // In the velocity pass a point that carries nothing may still close what is left of its gap.
    const bool closing = pass == ContactPass::Motion || row.impulse[i] <= 0.0;
    if (closing) e[i] += std::max(row.bias[i], 0.0);
    if (pass == ContactPass::Velocity && row.bounces) e[i] -= row.bounce[i];
    active = active || e[i] < 0.0 || row.impulse[i] > 0.0;
  }
  if (!active) return 0.0;
  e += sum(row.idle * row.impulse) * row.idle;
  const FourByFour B = mobility_of(row);
  const double change = disagreement(row, B, e);
  const Vec3 slip(row.t1.dot(motion.v), t2.dot(motion.v), row.normal.dot(motion.w));
  Four pressed = Four::Zero();  // N s, changes so far
  Vec3 rubbed = Vec3::Zero();   // of F_1, F_2, T_n
  const Mat3 coupling = row.slip();
  for (int turn = 0; turn < turns; ++turn) {
    const Four dz = solve_lcp(row.count, B, row.impulse, e);
    row.impulse += dz;
    pressed += dz;
    if (!row.rubs()) break;
    // Friction sees what the normals have just done, and they what it does.
    const Vec3 rub_change =
        rub(row, slip + coupling * press_of(row, pressed) + gripped(row, rubbed));
    rubbed += rub_change;
    if (turn + 1 == turns) break;
    const Vec3 back = coupling.transpose() * rub_change;
    e += times(B, dz) + back[0] + back[1] * row.s + back[2] * row.r;
  }
  const Vec3 press = press_of(row, pressed);
  apply_wrench(
      row, t2,
      {.force = {press[0], rubbed[0], rubbed[1]}, .couple = {rubbed[2], press[1], press[2]}}, a, b,
      &SolverBody::v, &SolverBody::w);
  return change;
}

void push_row(const ContactRow& row, std::span<SolverBody> bodies, std::span<std::uint8_t> pushed) {
  if (!row.sunk && pushed[row.a] == 0 && pushed[row.b] == 0) return;
  SolverBody& a = bodies[row.a];
  SolverBody& b = bodies[row.b];
  const double share = share_of_lower(row, a, b);
  if (share < 1.0) {
    if (!push_from_below(row, share, a, b)) return;
  } else if (row.count == 1 ? !push_point(row, a, b) : !push_face(row, a, b)) {
    return;
  }
  // What cannot move may be shared by rows that are solved at once.
  if (a.inv_mass > 0.0) pushed[row.a] = 1;
  if (b.inv_mass > 0.0) pushed[row.b] = 1;
}

}  // namespace tandem::pbd
