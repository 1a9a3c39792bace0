// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include <algorithm>
#include <cmath>

namespace tandem::pbd {

void ContactConvergence::begin_step(std::span<const SolverBody> bodies, const BodyOrder& order) {
  islands_.assign(bodies.size(), {});
  for (std::uint32_t rank = 0; rank < bodies.size(); ++rank) {
    const SolverBody& body = bodies[order.slot(rank)];
    if (body.group == SolverBody::kNoGroup) continue;
    islands_[body.island].speed2 += body.v.squaredNorm();
    ++islands_[body.island].bodies;
  }
}

void ContactConvergence::drop_solved(const Rule& rule, std::span<const ContactRow> rows,
                                     std::span<const double> changes,
                                     std::span<const SolverBody> bodies) {
  const auto island_of = [&](std::uint32_t k) -> Island& {
    return islands_[bodies[rows[k].movable()].island];
  };
  for (const std::uint32_t k : places_) {
    island_of(k).change2 = 0.0;
    island_of(k).rows = 0;
  }
  for (const std::uint32_t k : places_) {
    island_of(k).change2 += changes[k] * changes[k];
    ++island_of(k).rows;
  }
  std::erase_if(places_, [&](std::uint32_t k) {
    const Island& island = island_of(k);
    return !island.worth_it() || island.change2 <= rule.resting * rule.resting * island.rows;
  });
}

int ContactConvergence::run(const Rule& rule, const ContactOrder::Places& places, bool reverse,
                            std::span<ContactRow> rows, std::span<double> changes,
                            std::span<SolverBody> bodies) {
  if (rule.sweeps == 0) return 0;
  places_.clear();
  for (std::uint32_t k = places.begin; k < places.end; ++k) places_.push_back(k);
  int swept = 0;
  for (int sweep = 0; sweep <= rule.sweeps; ++sweep) {
    drop_solved(rule, rows, changes, bodies);
    if (places_.empty() || sweep == rule.sweeps) break;
    reverse = !reverse;
    const std::size_t n = places_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t k = places_[reverse ? n - 1 - i : i];
      islands_[bodies[rows[k].movable()].island].hard = true;
      changes[k] = solve_row(rows[k], ContactPass::Motion, rule.fresh, bodies);
    }
    swept += static_cast<int>(n);
  }
  return swept;
}

}  // namespace tandem::pbd
