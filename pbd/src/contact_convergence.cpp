// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace tandem::pbd {
namespace {

/// Of a positive speed: the exponent of its binary number.
std::size_t octave_of(float speed) { return std::bit_cast<std::uint32_t>(speed) >> 23; }

/// The last of the budget is left over: looking for so few rows costs more than they bring.
constexpr int kNotWorthIt = 8;

}  // namespace

void ContactConvergence::note(const ContactRow& row, double change,
                              std::span<const SolverBody> bodies) {
  const auto speed = static_cast<float>(change);
  for (const std::uint32_t body : {row.a, row.b}) {
    if (bodies[body].inv_mass > 0.0) moved_[body] = std::max(moved_[body], speed);
  }
}

void ContactConvergence::keep_most_moved(std::span<const ContactRow> rows, int most) {
  octaves_.fill(0);
  for (const std::uint32_t k : open_) ++octaves_[octave_of(moved(rows[k]))];
  std::size_t lowest = octaves_.size();
  int sum = 0;
  while (lowest > 0 && sum + octaves_[lowest - 1] <= most) sum += octaves_[--lowest];
  std::erase_if(open_, [&](std::uint32_t k) { return octave_of(moved(rows[k])) < lowest; });
}

ContactConvergence::Outcome ContactConvergence::run(const Rule& rule,
                                                    const ContactOrder::Places& places,
                                                    bool reverse, std::span<ContactRow> rows,
                                                    std::span<double> changes,
                                                    std::span<SolverBody> bodies) {
  Outcome outcome;
  const auto first = changes.begin() + places.begin;
  const auto last = changes.begin() + places.end;
  const bool solved = std::none_of(first, last, [&](double c) { return c > rule.tolerance; });
  if (rule.rows == 0 || solved) return outcome;
  moved_.assign(bodies.size(), 0.0f);
  for (std::uint32_t k = places.begin; k < places.end; ++k) note(rows[k], changes[k], bodies);
  for (;;) {
    open_.clear();
    for (std::uint32_t k = places.begin; k < places.end; ++k) {
      if (moved(rows[k]) > rule.tolerance) open_.push_back(k);
    }
    outcome.open = static_cast<int>(open_.size());
    const int left = rule.rows - outcome.swept;
    if (left < rule.rows / kNotWorthIt) return outcome;
    if (outcome.open > left) keep_most_moved(rows, left);
    if (open_.empty()) return outcome;
    for (const std::uint32_t k : open_) moved_[rows[k].a] = moved_[rows[k].b] = 0.0f;
    reverse = !reverse;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const std::uint32_t k = open_[reverse ? open_.size() - 1 - i : i];
      changes[k] = solve_row(rows[k], ContactPass::Motion, rule.fresh, bodies);
    }
    for (const std::uint32_t k : open_) note(rows[k], changes[k], bodies);
    outcome.swept += static_cast<int>(open_.size());
  }
}

}  // namespace tandem::pbd
