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

void set_mobility(const Manifold& m, const SolverBody& a, const SolverBody& b, TotalRow& row) {
  row.arms = arms_of(m, a, b);
  for (int i = 0; i < m.count; ++i) {
    const Vec3 response_a = a.inv_inertia_w * row.arms.a[i].cross(m.normal);
    const Vec3 response_b = b.inv_inertia_w * row.arms.b[i].cross(m.normal);
    for (int j = 0; j <= i; ++j) {
      const double value = a.inv_mass + b.inv_mass + row.arms.a[j].cross(m.normal).dot(response_a) +
                           row.arms.b[j].cross(m.normal).dot(response_b);
      row.mobility[i][j] = value;
      row.mobility[j][i] = value;
    }
  }
}

/// Move the bodies until the points' errors e (m) are none or carry nothing.
void project_points(const Manifold& m, SolverBody& a, SolverBody& b, TotalRow& row,
                    std::array<double, 4>& e) {
  std::array<double, 4> dz{};
  double first = 0.0;
  for (int sweep = 0; sweep < kInnerSweeps; ++sweep) {
    double largest = 0.0;
    for (int i = 0; i < m.count; ++i) {
      const double diagonal = row.mobility[i][i];
      if (!(diagonal > 0.0)) continue;
      const double change = std::max(-row.lambda[i], -e[i] / diagonal);
      row.lambda[i] += change;
      dz[i] += change;
      for (int j = 0; j < m.count; ++j) e[j] += row.mobility[i][j] * change;
      largest = std::max(largest, std::abs(change) * diagonal);
    }
    if (sweep == 0) first = largest;
    if (m.count == 1 || largest <= kInnerTolerance * first) break;
  }
  double sum = 0.0;
  Vec3 arm_a = Vec3::Zero();
  Vec3 arm_b = Vec3::Zero();
  for (int i = 0; i < m.count; ++i) {
    sum += dz[i];
    arm_a += dz[i] * row.arms.a[i];
    arm_b += dz[i] * row.arms.b[i];
  }
  apply_correction(a, -sum * m.normal, -arm_a.cross(m.normal));
  apply_correction(b, sum * m.normal, arm_b.cross(m.normal));
}

}  // namespace

void ContactBlock::begin_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (m.total.size() <= ctx.group) m.total.resize(ctx.group + 1);
  std::vector<TotalRow>& rows = m.total[ctx.group];
  rows.clear();
  const ContactOrder::Places places = m.order.range(ctx.group);
  for (std::uint32_t k = places.begin; k < places.end; ++k) {
    const ContactRow& solved = m.rows[k];
    SolverBody& a = ctx.bodies[solved.a];
    SolverBody& b = ctx.bodies[solved.b];
    if (!a.total && !b.total) continue;
    const Contact& contact = m.contacts[solved.contact];
    TotalRow& row = rows.emplace_back();
    row.contact = solved.contact;
    set_mobility(contact.manifold, a, b, row);
    for (int i = 0; i < solved.count; ++i) {
      row.bound[i] = std::min(0.0, gap_of(contact.manifold, a, b, i) - contact.debt[i]);
    }
  }
}

void ContactBlock::project_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (ctx.group >= m.total.size()) return;
  std::vector<TotalRow>& rows = m.total[ctx.group];
  const std::size_t n = rows.size();
  for (std::size_t k = 0; k < n; ++k) {
    TotalRow& row = rows[ctx.reverse ? n - 1 - k : k];
    const Manifold& manifold = m.contacts[row.contact].manifold;
    SolverBody& a = ctx.bodies[manifold.body_a];
    SolverBody& b = ctx.bodies[manifold.body_b];
    std::array<double, 4> e{};
    bool active = false;
    for (int i = 0; i < manifold.count; ++i) {
      e[i] = gap_of(manifold, a, b, i) - row.bound[i];
      active = active || e[i] < 0.0 || row.lambda[i] > 0.0;
    }
    if (active) project_points(manifold, a, b, row, e);
  }
}

void ContactBlock::end_total(const SubstepContext& ctx) {
  Impl& m = *impl_;
  if (ctx.group >= m.total.size()) return;
  for (const TotalRow& row : m.total[ctx.group]) {
    Contact& contact = m.contacts[row.contact];
    const SolverBody& a = ctx.bodies[contact.manifold.body_a];
    const SolverBody& b = ctx.bodies[contact.manifold.body_b];
    for (int i = 0; i < contact.manifold.count; ++i) {
      contact.debt[i] = std::min(0.0, gap_of(contact.manifold, a, b, i) - row.bound[i]);
    }
  }
}

bool ContactBlock::clean_up(const SubstepContext& ctx) {
  Impl& m = *impl_;
  bool any = false;
  const auto repair = [&](std::uint32_t contact, const auto& goal_of) {
    const Manifold& manifold = m.contacts[contact].manifold;
    SolverBody& a = ctx.bodies[manifold.body_a];
    SolverBody& b = ctx.bodies[manifold.body_b];
    std::array<double, 4> e{};
    bool active = false;
    for (int i = 0; i < manifold.count; ++i) {
      e[i] = gap_of(manifold, a, b, i) - goal_of(i);
      active = active || e[i] < 0.0;
    }
    if (!active) return;
    any = true;
    TotalRow row;
    set_mobility(manifold, a, b, row);
    project_points(manifold, a, b, row, e);
  };
  for (const std::vector<TotalRow>& rows : m.total) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const TotalRow& row = rows[ctx.reverse ? rows.size() - 1 - k : k];
      repair(row.contact, [&](int i) { return std::max(row.bound[i], -m.options.clean_up_slop); });
    }
  }
  return any;
}

}  // namespace tandem::pbd
