// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/corrections.h"

namespace tandem::pbd {
namespace {

/// Sweeps of the inner solve of one manifold; it stops earlier where it has converged.
constexpr int kInnerSweeps = 12;
/// Relative change below which it has.
constexpr double kInnerTolerance = 1e-6;

/// m/s: relative velocity of a point without contact, high enough that the solve leaves it out.
constexpr double kNotTouching = 1e30;

/// m: where a feature id is new, a point this close to an old one still takes over its multiplier.
constexpr double kAnchorMatch = 0.02;

/// Solve  0 <= z  _|_  e + B (z - z_0) + S z >= 0  for up to four unknowns by projected
/// Gauss-Seidel, B the mobility, S = softness diag(B) and z_0 the values on entry. On return `z`
/// holds the new values and `dz` their changes. Returns the largest change of e in the first sweep.
double solve_normals(const ContactRow& row, double softness, std::array<double, 4>& z,
                     std::array<double, 4>& e, std::array<double, 4>& dz) {
  const int n = row.manifold.count;
  double first = 0.0;
  for (int i = 0; i < n; ++i) e[i] += softness * row.mobility[i][i] * z[i];
  for (int sweep = 0; sweep < kInnerSweeps; ++sweep) {
    double largest = 0.0;
    for (int i = 0; i < n; ++i) {
      const double diagonal = (1.0 + softness) * row.mobility[i][i];
      if (diagonal <= 0.0) continue;
      const double change = std::max(-z[i], -e[i] / diagonal);
      if (change == 0.0) continue;
      z[i] += change;
      dz[i] += change;
      for (int j = 0; j < n; ++j) e[j] += row.mobility[i][j] * change;
      e[i] += softness * row.mobility[i][i] * change;
      largest = std::max(largest, std::abs(change) * diagonal);
    }
    if (sweep == 0) first = largest;
    if (n == 1 || largest <= kInnerTolerance * first) break;
  }
  return first;
}

struct Pair {
  SolverBody& a;
  SolverBody& b;
};

Pair bodies_of(const ContactRow& row, const SubstepContext& ctx) {
  return {ctx.bodies[row.manifold.body_a], ctx.bodies[row.manifold.body_b]};
}

/// Gap of point i as the bodies stand now.
double gap_of(const ContactRow& row, const Pair& pair, int i) {
  const Manifold& m = row.manifold;
  const Vec3 p_a = pair.a.x + pair.a.q * m.points[i].anchor_a_l;
  const Vec3 p_b = pair.b.x + pair.b.q * m.points[i].anchor_b_l;
  return m.normal.dot(p_b - p_a) - m.radius_a - m.radius_b;
}

/// Lever arms to a common point of both bodies, so that a pair of opposite impulses keeps angular
/// momentum, whatever slid since detection: half-way between the two anchors, or below the centre
/// of the one that is round, which its normal must not turn (a ball would speed up as it rolls).
void set_arms(ContactRow& row, const Pair& pair) {
  const Manifold& m = row.manifold;
  const bool round_a = m.radius_a > 0.0;
  const bool round_b = m.radius_b > 0.0;
  const double share_b = round_a == round_b ? 0.5 : (round_b ? 1.0 : 0.0);
  for (int i = 0; i < m.count; ++i) {
    const Vec3 p_a = pair.a.x + pair.a.q * m.points[i].anchor_a_l + m.radius_a * m.normal;
    const Vec3 p_b = pair.b.x + pair.b.q * m.points[i].anchor_b_l - m.radius_b * m.normal;
    const Vec3 p = p_a + share_b * (p_b - p_a);
    row.arm_a[i] = p - pair.a.x;
    row.arm_b[i] = p - pair.b.x;
  }
}

void set_mobility(ContactRow& row, const Pair& pair) {
  const Manifold& m = row.manifold;
  std::array<Vec3, 4> rn_a, rn_b, response_a, response_b;
  for (int i = 0; i < m.count; ++i) {
    rn_a[i] = row.arm_a[i].cross(m.normal);
    rn_b[i] = row.arm_b[i].cross(m.normal);
    response_a[i] = pair.a.inv_inertia_w * rn_a[i];
    response_b[i] = pair.b.inv_inertia_w * rn_b[i];
  }
  const double linear = pair.a.inv_mass + pair.b.inv_mass;
  for (int i = 0; i < m.count; ++i) {
    for (int j = 0; j <= i; ++j) {
      const double value = linear + rn_a[i].dot(response_a[j]) + rn_b[i].dot(response_b[j]);
      row.mobility[i][j] = value;
      row.mobility[j][i] = value;
    }
  }
}

/// Apply the multipliers `dz` along the normals as one correction for each body.
void apply_normals(const ContactRow& row, const Pair& pair, const std::array<double, 4>& dz) {
  const Vec3& n = row.manifold.normal;
  double sum = 0.0;
  Vec3 arm_a = Vec3::Zero();
  Vec3 arm_b = Vec3::Zero();
  for (int i = 0; i < row.manifold.count; ++i) {
    sum += dz[i];
    arm_a += dz[i] * row.arm_a[i];
    arm_b += dz[i] * row.arm_b[i];
  }
  apply_correction(pair.a, -sum * n, -arm_a.cross(n));
  apply_correction(pair.b, sum * n, arm_b.cross(n));
}

/// Friction acts at the centre of pressure of the normals. Where that is, and how easily the bodies
/// slide and twist there, is found once for each substep.
void set_friction_point(ContactRow& row, const Pair& pair) {
  const Manifold& m = row.manifold;
  double load = 0.0;
  Vec3 arm_a = Vec3::Zero();
  Vec3 arm_b = Vec3::Zero();
  for (int i = 0; i < m.count; ++i) {
    load += row.lambda[i];
    arm_a += row.lambda[i] * row.arm_a[i];
    arm_b += row.lambda[i] * row.arm_b[i];
  }
  row.grips = load > 0.0;
  if (!row.grips) return;
  row.centre_a = arm_a / load;
  row.centre_b = arm_b / load;

  const std::array<Vec3, 2> t{row.tangent_1, row.tangent_2};
  Eigen::Matrix2d k;
  for (int i = 0; i < 2; ++i) {
    const Vec3 response_a = pair.a.inv_inertia_w * row.centre_a.cross(t[i]);
    const Vec3 response_b = pair.b.inv_inertia_w * row.centre_b.cross(t[i]);
    for (int j = 0; j < 2; ++j) {
      k(i, j) = (i == j ? pair.a.inv_mass + pair.b.inv_mass : 0.0) +
                row.centre_a.cross(t[j]).dot(response_a) + row.centre_b.cross(t[j]).dot(response_b);
    }
  }
  row.slide_mass = k.inverse();
  const double w = m.normal.dot((pair.a.inv_inertia_w + pair.b.inv_inertia_w) * m.normal);
  row.twist_mass = m.count > 1 && w > 0.0 ? 1.0 / w : 0.0;
}

/// How far friction reaches for the load that the normals carry (N s^2 or N s).
struct FrictionLimit {
  double slide = 0.0;
  double twist = 0.0;  ///< the load's spread about its centre turns it into a moment
};

FrictionLimit friction_limit(const ContactRow& row, double h) {
  FrictionLimit limit;
  for (int i = 0; i < row.manifold.count; ++i) {
    const double load = std::max(0.0, row.lambda[i] + h * row.impulse[i]);
    const Vec3 lever = row.arm_a[i] - row.centre_a;
    limit.slide += load;
    limit.twist += load * (lever - lever.dot(row.manifold.normal) * row.manifold.normal).norm();
  }
  limit.slide *= row.manifold.friction;
  limit.twist *= row.manifold.friction;
  return limit;
}

/// Cut both multipliers back to the ellipsoid (slide / limit)^2 + (twist / limit)^2 <= 1, about
/// what a patch can do at once, at the point where friction dissipates most: a body that spins fast
/// hardly resists being pushed. Two limits of their own would brake such a body twice over.
void keep_within(ContactRow& row, const FrictionLimit& limit) {
  constexpr int kIterations = 10;
  const double k_slide = 2.0 / row.slide_mass.trace();
  const double k_twist = row.twist_mass > 0.0 ? 1.0 / row.twist_mass : 0.0;
  const double p = k_slide * limit.slide * limit.slide;
  const double q = k_twist * limit.twist * limit.twist;
  if (!(q > 0.0)) row.twist = 0.0;
  if (!(p > 0.0)) {
    row.friction.setZero();
    return;
  }
  // The bound's own multiplier, by Newton's iteration on 1 / use - 1, which is nearly straight.
  const double a = k_slide * row.friction.norm() * limit.slide;
  const double b = k_twist * std::abs(row.twist) * limit.twist;
  double bound = 0.0;
  double use = 0.0;
  for (int i = 0; i < kIterations; ++i) {
    const double s = a / (p + bound);
    const double t = q > 0.0 ? b / (q + bound) : 0.0;
    use = std::sqrt(s * s + t * t);
    if (use <= 1.0 + 1e-9) break;
    bound +=
        (use - 1.0) * use * use / (s * s / (p + bound) + (q > 0.0 ? t * t / (q + bound) : 0.0));
  }
  const double rest = std::max(1.0, use);
  row.friction *= p / ((p + bound) * rest);
  if (q > 0.0) row.twist *= q / ((q + bound) * rest);
}

/// Multipliers that undo a slip (m) and a twist (rad) within the cone. Both passes of a substep
/// share one budget: `row.friction` and `row.twist` hold what has been used of it.
struct FrictionChange {
  Vec3 slide = Vec3::Zero();   ///< N s^2, world
  Vec3 moment = Vec3::Zero();  ///< N m s^2, world
};

FrictionChange undo_slip(ContactRow& row, double h, const Vec3& slip, double turn) {
  const FrictionLimit limit = friction_limit(row, h);
  const Eigen::Vector2d before = row.friction;
  row.friction -=
      row.slide_mass * Eigen::Vector2d(slip.dot(row.tangent_1), slip.dot(row.tangent_2));
  const double twist = row.twist;
  row.twist -= row.twist_mass * turn;
  keep_within(row, limit);
  const Eigen::Vector2d change = row.friction - before;
  return {change[0] * row.tangent_1 + change[1] * row.tangent_2,
          (row.twist - twist) * row.manifold.normal};
}

/// Undo what this substep has slid so far.
void solve_position_friction(ContactRow& row, const Pair& pair, double h) {
  set_friction_point(row, pair);
  if (!row.grips) return;
  const Vec3 slip =
      point_displacement(pair.b, row.centre_b, h) - point_displacement(pair.a, row.centre_a, h);
  const double turn =
      row.manifold.normal.dot(h * (pair.b.w - pair.a.w) + pair.b.dtheta - pair.a.dtheta);
  const FrictionChange f = undo_slip(row, h, slip, turn);
  apply_correction(pair.a, -f.slide, -row.centre_a.cross(f.slide) - f.moment);
  apply_correction(pair.b, f.slide, row.centre_b.cross(f.slide) + f.moment);
}

/// Stop the sliding that the velocity pass itself has brought about.
void solve_velocity_friction(ContactRow& row, const Pair& pair, double h) {
  if (!row.grips) return;
  const Vec3 slip =
      h * (point_velocity(pair.b, row.centre_b) - point_velocity(pair.a, row.centre_a));
  const double turn = h * row.manifold.normal.dot(pair.b.w - pair.a.w);
  const FrictionChange f = undo_slip(row, h, slip, turn);
  const double rate = 1.0 / h;
  apply_velocity_pair(pair.a, pair.b, rate * f.slide, row.centre_a, row.centre_b);
  pair.a.w -= rate * (pair.a.inv_inertia_w * f.moment);
  pair.b.w += rate * (pair.b.inv_inertia_w * f.moment);
}

template <class Rows, class Visit>
void sweep(Rows& rows, bool reverse, Visit&& visit) {
  const std::size_t n = rows.size();
  for (std::size_t k = 0; k < n; ++k) visit(rows[reverse ? n - 1 - k : k]);
}

bool in_total(const ContactRow& row, const SubstepContext& ctx) {
  return ctx.bodies[row.manifold.body_a].total || ctx.bodies[row.manifold.body_b].total;
}

/// Carry multipliers from the old row of the same pair to the new one.
void carry(const ContactRow& old, ContactRow& row, double scale) {
  std::array<bool, 4> taken{};
  std::array<bool, 4> done{};
  const auto take = [&](int i, int j) {
    row.lambda[i] = old.lambda[j] * scale;
    row.gap[i] = old.gap[j];
    taken[j] = true;
    done[i] = true;
  };
  for (int i = 0; i < row.manifold.count; ++i) {
    for (int j = 0; j < old.manifold.count; ++j) {
      if (!taken[j] && row.manifold.points[i].feature == old.manifold.points[j].feature) {
        take(i, j);
        break;
      }
    }
  }
  for (int i = 0; i < row.manifold.count; ++i) {
    if (done[i]) continue;
    int best = -1;
    double nearest = kAnchorMatch * kAnchorMatch;
    for (int j = 0; j < old.manifold.count; ++j) {
      const double d2 =
          (row.manifold.points[i].anchor_b_l - old.manifold.points[j].anchor_b_l).squaredNorm();
      if (!taken[j] && d2 < nearest) {
        nearest = d2;
        best = j;
      }
    }
    if (best >= 0) take(i, best);
  }
}

}  // namespace

void ContactBlock::configure(const ContactOptions& options, double gravity_norm) {
  options_ = options;
  bounce_acceleration_ = options.restitution_threshold * gravity_norm;
}

void ContactBlock::set_manifolds(std::vector<Manifold>& manifolds, double h_ratio) {
  const auto by_key = [](const Manifold& l, const Manifold& r) { return l.key < r.key; };
  if (!std::is_sorted(manifolds.begin(), manifolds.end(), by_key)) {
    std::sort(manifolds.begin(), manifolds.end(), by_key);
  }
  std::swap(rows_, previous_);
  rows_.clear();
  const double scale = h_ratio * h_ratio;
  std::size_t j = 0;
  for (const Manifold& manifold : manifolds) {
    ContactRow& row = rows_.emplace_back();
    row.manifold = manifold;
    tangent_frame(manifold.normal, row.tangent_1, row.tangent_2);
    while (j < previous_.size() && previous_[j].manifold.key < manifold.key) ++j;
    if (j < previous_.size() && previous_[j].manifold.key == manifold.key) {
      carry(previous_[j], row, scale);
    }
  }
}

void ContactBlock::begin_substep(const SubstepContext& ctx) {
  for (ContactRow& row : rows_) {
    const Pair pair = bodies_of(row, ctx);
    const Manifold& m = row.manifold;
    set_arms(row, pair);
    const bool free = !in_total(row, ctx);
    for (int i = 0; i < m.count; ++i) {
      if (free) row.gap[i] *= kGapDecay;
      row.overlap[i] = std::max(0.0, row.gap[i] - gap_of(row, pair, i));
      row.speed[i] =
          m.normal.dot(point_velocity(pair.b, row.arm_b[i]) - point_velocity(pair.a, row.arm_a[i]));
      row.impulse[i] = 0.0;
    }
    row.friction.setZero();
    row.twist = 0.0;
    row.grips = false;
  }
}

void ContactBlock::warm_start(const SubstepContext& ctx) {
  for (ContactRow& row : rows_) {
    const Pair pair = bodies_of(row, ctx);
    set_arms(row, pair);
    set_mobility(row, pair);
    bool any = false;
    for (int i = 0; i < row.manifold.count; ++i) {
      if (row.lambda[i] > 0.0 && gap_of(row, pair, i) >= options_.warm_start_gap) {
        row.lambda[i] = 0.0;
      }
      any = any || row.lambda[i] > 0.0;
    }
    if (any) apply_normals(row, pair, row.lambda);
  }
}

double ContactBlock::project(const SubstepContext& ctx) {
  double largest = 0.0;
  const double push = options_.push_speed * ctx.h;
  sweep(rows_, ctx.reverse, [&](ContactRow& row) {
    const Pair pair = bodies_of(row, ctx);
    std::array<double, 4> e{};
    bool active = false;
    for (int i = 0; i < row.manifold.count; ++i) {
      // Overlap that was there before the substep is let out slowly; what this substep's motion
      // added is undone at once.
      e[i] = gap_of(row, pair, i) - row.gap[i] + std::max(0.0, row.overlap[i] - push);
      active = active || e[i] < 0.0 || row.lambda[i] > 0.0;
    }
    if (!active) return;
    std::array<double, 4> dz{};
    largest = std::max(largest, solve_normals(row, options_.softness, row.lambda, e, dz));
    apply_normals(row, pair, dz);
    if (row.manifold.friction > 0.0) solve_position_friction(row, pair, ctx.h);
  });
  return largest;
}

double ContactBlock::solve_velocity(const SubstepContext& ctx) {
  double change = 0.0;
  sweep(rows_, ctx.reverse, [&](ContactRow& row) {
    const Manifold& m = row.manifold;
    const Pair pair = bodies_of(row, ctx);
    std::array<double, 4> e{};
    std::array<double, 4> z{};
    bool active = false;
    for (int i = 0; i < m.count; ++i) {
      z[i] = row.lambda[i] / ctx.h + row.impulse[i];
      active = active || row.lambda[i] > 0.0;
      const bool bounces = -row.speed[i] > bounce_acceleration_ * ctx.h;
      const double target = bounces ? std::max(-m.restitution * row.speed[i], 0.0) : 0.0;
      e[i] = m.normal.dot(point_velocity(pair.b, row.arm_b[i]) -
                          point_velocity(pair.a, row.arm_a[i])) -
             target;
      if (row.lambda[i] <= 0.0) e[i] = kNotTouching;
    }
    if (!active) return;
    std::array<double, 4> dz{};
    change = std::max(change, solve_normals(row, 0.0, z, e, dz));
    double sum = 0.0;
    Vec3 arm_a = Vec3::Zero();
    Vec3 arm_b = Vec3::Zero();
    for (int i = 0; i < m.count; ++i) {
      row.impulse[i] += dz[i];
      sum += dz[i];
      arm_a += dz[i] * row.arm_a[i];
      arm_b += dz[i] * row.arm_b[i];
    }
    const Vec3 p = sum * m.normal;
    pair.a.v -= pair.a.inv_mass * p;
    pair.a.w -= pair.a.inv_inertia_w * arm_a.cross(m.normal);
    pair.b.v += pair.b.inv_mass * p;
    pair.b.w += pair.b.inv_inertia_w * arm_b.cross(m.normal);
    if (m.friction > 0.0) solve_velocity_friction(row, pair, ctx.h);
  });
  return change;
}

void ContactBlock::begin_total(const SubstepContext& ctx) {
  for (ContactRow& row : rows_) {
    if (!in_total(row, ctx)) continue;
    const Pair pair = bodies_of(row, ctx);
    set_arms(row, pair);
    set_mobility(row, pair);
    for (int i = 0; i < row.manifold.count; ++i) {
      row.bound[i] = std::min(0.0, gap_of(row, pair, i) - row.gap[i]);
      row.total[i] = 0.0;
    }
  }
}

void ContactBlock::project_total(const SubstepContext& ctx) {
  sweep(rows_, ctx.reverse, [&](ContactRow& row) {
    if (!in_total(row, ctx)) return;
    const Pair pair = bodies_of(row, ctx);
    std::array<double, 4> e{};
    bool active = false;
    for (int i = 0; i < row.manifold.count; ++i) {
      e[i] = gap_of(row, pair, i) - row.bound[i];
      active = active || e[i] < 0.0 || row.total[i] > 0.0;
    }
    if (!active) return;
    std::array<double, 4> dz{};
    solve_normals(row, 0.0, row.total, e, dz);
    apply_normals(row, pair, dz);
  });
}

void ContactBlock::end_total(const SubstepContext& ctx) {
  for (ContactRow& row : rows_) {
    if (!in_total(row, ctx)) continue;
    const Pair pair = bodies_of(row, ctx);
    for (int i = 0; i < row.manifold.count; ++i) {
      row.gap[i] = std::min(0.0, gap_of(row, pair, i) - row.bound[i]);
    }
  }
}

void ContactBlock::clean_up(const SubstepContext& ctx) {
  const double push = options_.push_speed * ctx.h;
  sweep(rows_, ctx.reverse, [&](ContactRow& row) {
    const Pair pair = bodies_of(row, ctx);
    const bool total = in_total(row, ctx);
    std::array<double, 4> e{};
    std::array<double, 4> unused{};
    bool active = false;
    for (int i = 0; i < row.manifold.count; ++i) {
      const double allowed = std::max(options_.clean_up_slop, row.overlap[i] - push);
      const double goal = total ? std::max(row.bound[i], -allowed) : -allowed;
      e[i] = gap_of(row, pair, i) - goal;
      active = active || e[i] < 0.0;
    }
    if (!active) return;
    set_arms(row, pair);
    set_mobility(row, pair);
    std::array<double, 4> dz{};
    solve_normals(row, 0.0, unused, e, dz);
    apply_normals(row, pair, dz);
  });
}

void ContactBlock::end_step(const SubstepContext& ctx) {
  residual_ = 0.0;
  total_residual_ = 0.0;
  for (ContactRow& row : rows_) {
    const Pair pair = bodies_of(row, ctx);
    for (int i = 0; i < row.manifold.count; ++i) {
      residual_ = std::max(residual_, -gap_of(row, pair, i));
      total_residual_ = std::max(total_residual_, -row.gap[i]);
      // What a spoiled step leaves behind must not spoil the next one.
      if (!std::isfinite(row.lambda[i])) row.lambda[i] = 0.0;
      if (!std::isfinite(row.gap[i])) row.gap[i] = 0.0;
    }
  }
}

void ContactBlock::links(LinkVisitor& visitor) const {
  for (const ContactRow& row : rows_) visitor.link(row.manifold.body_a, row.manifold.body_b);
}

void ContactBlock::remove_body(BodyId body) {
  std::erase_if(rows_, [&](const ContactRow& row) {
    return row.manifold.body_a == body.index || row.manifold.body_b == body.index;
  });
}

BlockReport ContactBlock::report() const {
  return {.name = name(),
          .rows = static_cast<int>(rows_.size()),
          .residual = residual_,
          .total_residual = total_residual_};
}

void ContactBlock::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(rows_.size()));
  for (const ContactRow& row : rows_) {
    const Manifold& m = row.manifold;
    out.u64(m.key);
    out.u32(m.body_a);
    out.u32(m.body_b);
    out.vec3(m.normal);
    for (const double value : {m.radius_a, m.radius_b, m.friction, m.restitution}) out.f64(value);
    out.u8(static_cast<std::uint8_t>(m.count));
    for (int i = 0; i < m.count; ++i) {
      out.vec3(m.points[i].anchor_a_l);
      out.vec3(m.points[i].anchor_b_l);
      out.u32(m.points[i].feature);
      out.f64(row.lambda[i]);
      out.f64(row.gap[i]);
    }
  }
}

void ContactBlock::load(ByteReader& in) {
  rows_.clear();
  const std::uint32_t size = in.u32();
  for (std::uint32_t k = 0; k < size && !in.failed(); ++k) {
    ContactRow& row = rows_.emplace_back();
    Manifold& m = row.manifold;
    m.key = in.u64();
    m.body_a = in.u32();
    m.body_b = in.u32();
    m.normal = in.vec3();
    for (double* value : {&m.radius_a, &m.radius_b, &m.friction, &m.restitution}) *value = in.f64();
    m.count = std::min<int>(in.u8(), Manifold::kMaxPoints);
    for (int i = 0; i < m.count; ++i) {
      m.points[i].anchor_a_l = in.vec3();
      m.points[i].anchor_b_l = in.vec3();
      m.points[i].feature = in.u32();
      row.lambda[i] = in.f64();
      row.gap[i] = in.f64();
    }
  }
}

}  // namespace tandem::pbd
