// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/bytes.h"

namespace tandem::pbd {

void ContactConvergence::begin_step(std::span<const SolverBody> bodies, const BodyOrder& order,
                                    std::span<const ContactRow> rows) {
  islands_.assign(bodies.size(), {});
  unsolved_.resize(bodies.size(), 0);
  for (std::uint32_t rank = 0; rank < bodies.size(); ++rank) {
    const SolverBody& body = bodies[order.slot(rank)];
    if (body.group == SolverBody::kNoGroup) continue;
    Island& island = islands_[body.island];
    island.speed2 += body.v.squaredNorm();
    island.unsolved += unsolved_[order.slot(rank)];
    ++island.bodies;
  }
  island_of_.resize(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    island_of_[k] = bodies[rows[k].movable()].island;
    ++islands_[island_of_[k]].rows;
  }
}

void ContactConvergence::end_step(std::span<const SolverBody> bodies) {
  constexpr std::uint8_t kMost = kPatience + kGrudge;
  for (std::uint32_t i = 0; i < bodies.size() && i < unsolved_.size(); ++i) {
    if (bodies[i].group == SolverBody::kNoGroup) continue;
    std::uint8_t& unsolved = unsolved_[i];
    if (islands_[bodies[i].island].open) {
      if (unsolved < kMost) ++unsolved;
    } else if (unsolved > 0) {
      --unsolved;
    }
  }
}

void ContactConvergence::remove_body(std::uint32_t slot) {
  if (slot < unsolved_.size()) unsolved_[slot] = 0;
}

void ContactConvergence::save(ByteWriter& out) const {
  out.u32(static_cast<std::uint32_t>(unsolved_.size()));
  for (const std::uint8_t steps : unsolved_) out.u8(steps);
}

void ContactConvergence::load(ByteReader& in) {
  unsolved_.clear();
  const std::uint32_t size = in.u32();
  for (std::uint32_t i = 0; i < size && !in.failed(); ++i) unsolved_.push_back(in.u8());
}

int ContactConvergence::run(const Rule& rule, const ContactOrder::Places& places, bool reverse,
                            std::span<ContactRow> rows, std::span<double> changes,
                            std::span<SolverBody> bodies) {
  if (rule.sweeps == 0) return 0;
  const auto island_of = [&](std::uint32_t k) -> Island& { return islands_[island_of_[k]]; };
  for (std::uint32_t k = places.begin; k < places.end; ++k) island_of(k).change2 = 0.0;
  for (std::uint32_t k = places.begin; k < places.end; ++k) {
    island_of(k).change2 += changes[k] * changes[k];
  }
  places_.clear();
  for (std::uint32_t k = places.begin; k < places.end; ++k) {
    Island& island = island_of(k);
    if (!island.worth_it() || !is_open(rule, island)) continue;
    if (island.given_up()) {
      island.open = true;
    } else {
      island.hard = true;
      places_.push_back(k);
    }
  }
  int swept = 0;
  for (int sweep = 0; sweep < rule.sweeps && !places_.empty(); ++sweep) {
    reverse = !reverse;
    const std::size_t n = places_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t k = places_[reverse ? n - 1 - i : i];
      changes[k] = solve_row(rows[k], ContactPass::Motion, rule.fresh, bodies);
    }
    swept += static_cast<int>(n);
    for (const std::uint32_t k : places_) island_of(k).change2 = 0.0;
    for (const std::uint32_t k : places_) island_of(k).change2 += changes[k] * changes[k];
    std::erase_if(places_, [&](std::uint32_t k) { return !is_open(rule, island_of(k)); });
  }
  for (const std::uint32_t k : places_) island_of(k).open = true;
  return swept;
}

}  // namespace tandem::pbd
