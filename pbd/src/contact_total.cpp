// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The contacts' part of the total channel and of the clean-up: the same rows for positions alone.
#include <algorithm>

#include "contact_impl.h"
#include "tandem/pbd/corrections.h"

namespace tandem::pbd {
namespace {

/// Sweeps over the points of one manifold.
constexpr int kInnerSweeps = 12;
constexpr double kInnerTolerance = 1e-6;

/// rad: bodies that turned less than this since the channel began have gaps that follow from their
/// displacements, to half a micrometre for a metre of lever arm.
constexpr double kStraight = 1e-3;

/// m: overlaps that agreement added are not worth another look below this.
constexpr double kClean = 1e-6;

/// Arms, mobility and gaps as the bodies stand.
void set_row(const Manifold& m, const SolverBody& a, const SolverBody& b, TotalRow& row) {
  row.a = m.body_a;
  row.b = m.body_b;
  row.count = m.count;
  row.normal = m.normal;
  const ContactArms arms = arms_of(m, a, b, &row.gap);
  for (int i = 0; i < m.count; ++i) {
    row.turn_a[i] = arms.a[i].cross(m.normal);
    row.turn_b[i] = arms.b[i].cross(m.normal);
    row.lambda[i] = 0.0;
    const Vec3 response_a = a.inv_inertia_w * row.turn_a[i];
    const Vec3 response_b = b.inv_inertia_w * row.turn_b[i];
    for (int j = 0; j <= i; ++j) {
      const double value =
          a.inv_mass + b.inv_mass + row.turn_a[j].dot(response_a) + row.turn_b[j].dot(response_b);
      row.mobility[i][j] = value;
      row.mobility[j][i] = value;
    }
  }
}

/// Multipliers that take away the points' errors e (m), or carry nothing.
/// @return their changes, N s^2
std::array<double, 4> solve_points(TotalRow& row, std::array<double, 4>& e) {
  std::array<double, 4> dz{};
  double first = 0.0;
  for (int sweep = 0; sweep < kInnerSweeps; ++sweep) {
    double largest = 0.0;
    for (int i = 0; i < row.count; ++i) {
      const double diagonal = row.mobility[i][i];
      if (!(diagonal > 0.0)) continue;
      const double change = std::max(-row.lambda[i], -e[i] / diagonal);
      row.lambda[i] += change;
      dz[i] += change;
      for (int j = 0; j < row.count; ++j) e[j] += row.mobility[i][j] * change;
      largest = std::max(largest, std::abs(change) * diagonal);
    }
    if (sweep == 0) first = largest;
    if (row.count == 1 || largest <= kInnerTolerance * first) break;
  }
  return dz;
}

/// What a row does to its bodies.
struct TotalPush {
  double along = 0.0;          ///< N s^2, along the normal on b, against it on a
  Vec3 turn_a = Vec3::Zero();  ///< N m s^2
  Vec3 turn_b = Vec3::Zero();
};
TotalPush push_of(const TotalRow& row, const std::array<double, 4>& dz) {
  TotalPush push;
  for (int i = 0; i < row.count; ++i) {
    push.along += dz[i];
    push.turn_a -= dz[i] * row.turn_a[i];
    push.turn_b += dz[i] * row.turn_b[i];
  }
  return push;
}

bool is_straight(const SolverBody& body) {
  return body.dtheta.squaredNorm() < kStraight * kStraight;
}

/// Gap of point i (m) where both bodies hardly turned since the channel began.
double straight_gap(const TotalRow& row, const SolverBody& a, const SolverBody& b, int i) {
  return row.gap[i] + row.normal.dot(b.dx - a.dx) + row.turn_b[i].dot(b.dtheta) -
         row.turn_a[i].dot(a.dtheta);
}

}  // namespace

void ContactBlock::Impl::forgive(const SubstepContext& ctx) {
  TotalRow row;
  for (Contact& contact : contacts) {
    const Manifold& m = contact.manifold;
    if (ctx.displaced[m.body_a] == 0 && ctx.displaced[m.body_b] == 0) continue;
    set_row(m, ctx.bodies[m.body_a], ctx.bodies[m.body_b], row);
    for (int i = 0; i < m.count; ++i) contact.debt[i] = std::min(0.0, row.gap[i]);
  }
}

void ContactBlock::begin_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (m.total.size() <= ctx.group) m.total.resize(ctx.group + 1);
  m.turns.resize(ctx.bodies.size(), Vec3::Zero());  // each sweep leaves zeros
  std::vector<TotalRow>& rows = m.total[ctx.group];
  rows.clear();
  const ContactOrder::Places places = m.order.range(ctx.group);
  for (std::uint32_t k = places.begin; k < places.end; ++k) {
    const ContactRows& solved = m.rows[k];
    for (std::size_t lane = 0; lane < solved.count; ++lane) {
      const SolverBody& a = ctx.bodies[solved.a[lane]];
      const SolverBody& b = ctx.bodies[solved.b[lane]];
      if (!a.total && !b.total) continue;
      const Contact& contact = m.contacts[solved.contact[lane]];
      TotalRow& row = rows.emplace_back();
      row.contact = solved.contact[lane];
      set_row(contact.manifold, a, b, row);
      for (int i = 0; i < row.count; ++i) {
        row.bound[i] = std::min(0.0, row.gap[i] - contact.debt[i]);
      }
    }
  }
}

void ContactBlock::project_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (ctx.group >= m.total.size()) return;
  // Displacements are what the rows need of each other; orientations follow once for each sweep.
  const auto move = [&](std::uint32_t index, double along, const Vec3& normal, const Vec3& turn) {
    SolverBody& body = ctx.bodies[index];
    if (body.inv_mass == 0.0) return;
    const Vec3 dx = body.inv_mass * along * normal;
    const Vec3 dtheta = body.inv_inertia_w * turn;
    body.x += dx;
    body.dx += dx;
    if (dtheta.isZero(0.0)) return;  // a ball
    body.dtheta += dtheta;
    if (m.turns[index].isZero(0.0)) m.turned.push_back(index);
    m.turns[index] += dtheta;
  };
  const auto catch_up = [&](std::uint32_t index) {
    ctx.bodies[index].q = rotated(ctx.bodies[index].q, m.turns[index]);
    m.turns[index].setZero();
  };
  std::vector<TotalRow>& rows = m.total[ctx.group];
  const std::size_t n = rows.size();
  for (std::size_t k = 0; k < n; ++k) {
    TotalRow& row = rows[ctx.reverse ? n - 1 - k : k];
    const SolverBody& a = ctx.bodies[row.a];
    const SolverBody& b = ctx.bodies[row.b];
    const bool straight = is_straight(a) && is_straight(b);
    if (!straight) {
      catch_up(row.a);
      catch_up(row.b);
    }
    std::array<double, 4> e{};
    bool active = false;
    for (int i = 0; i < row.count; ++i) {
      const double gap =
          straight ? straight_gap(row, a, b, i) : gap_of(m.contacts[row.contact].manifold, a, b, i);
      e[i] = gap - row.bound[i];
      active = active || e[i] < 0.0 || row.lambda[i] > 0.0;
    }
    if (!active) continue;
    const TotalPush push = push_of(row, solve_points(row, e));
    move(row.a, -push.along, row.normal, push.turn_a);
    move(row.b, push.along, row.normal, push.turn_b);
  }
  for (const std::uint32_t index : m.turned) catch_up(index);
  m.turned.clear();
}

void ContactBlock::end_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (ctx.group >= m.total.size()) return;
  for (const TotalRow& row : m.total[ctx.group]) {
    Contact& contact = m.contacts[row.contact];
    const SolverBody& a = ctx.bodies[contact.manifold.body_a];
    const SolverBody& b = ctx.bodies[contact.manifold.body_b];
    const bool straight = is_straight(a) && is_straight(b);
    for (int i = 0; i < row.count; ++i) {
      const double gap = straight ? straight_gap(row, a, b, i) : gap_of(contact.manifold, a, b, i);
      contact.debt[i] = std::min(0.0, gap - row.bound[i]);
    }
  }
}

bool ContactBlock::clean_up(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (!ctx.shared) return false;
  const bool first = ctx.substep == 0;
  if (first) m.cleaned.assign(ctx.bodies.size(), 0);
  bool any = false;
  TotalRow row;
  for (const std::vector<TotalRow>& rows : m.total) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const TotalRow& solved = rows[ctx.reverse ? rows.size() - 1 - k : k];
      // What has not moved is as it was when it was looked at.
      if (!first && m.cleaned[solved.a] == 0 && m.cleaned[solved.b] == 0) continue;
      const Manifold& manifold = m.contacts[solved.contact].manifold;
      SolverBody& a = ctx.bodies[solved.a];
      SolverBody& b = ctx.bodies[solved.b];
      std::array<double, 4> e{};
      bool active = false;
      const bool straight = is_straight(a) && is_straight(b);
      for (int i = 0; i < solved.count; ++i) {
        const double gap = straight ? straight_gap(solved, a, b, i) : gap_of(manifold, a, b, i);
        e[i] = gap - std::max(solved.bound[i], -m.options.clean_up_slop);
        active = active || e[i] < -kClean;
      }
      if (!active) continue;
      any = true;
      set_row(manifold, a, b, row);
      const TotalPush push = push_of(row, solve_points(row, e));
      apply_correction(a, -push.along * row.normal, push.turn_a);
      apply_correction(b, push.along * row.normal, push.turn_b);
      m.cleaned[solved.a] = 1;
      m.cleaned[solved.b] = 1;
    }
  }
  return any;
}

}  // namespace tandem::pbd
