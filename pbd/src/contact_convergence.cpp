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

template <class Visit>
void for_lanes(LaneMask lanes, Visit&& visit) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    if (lanes >> i & 1u) visit(i);
  }
}

}  // namespace

void ContactConvergence::note(const ContactRows& rows, LaneMask lanes) {
  for_lanes(lanes, [&](std::size_t i) {
    const auto speed = static_cast<float>(rows.change[i]);
    if (rows.a_moves >> i & 1u) moved_[rows.a[i]] = std::max(moved_[rows.a[i]], speed);
    if (rows.b_moves >> i & 1u) moved_[rows.b[i]] = std::max(moved_[rows.b[i]], speed);
  });
}

void ContactConvergence::find_open(const ContactOrder::Places& places,
                                   std::span<const ContactRows> rows, float tolerance) {
  open_.clear();
  for (std::uint32_t k = places.begin; k < places.end; ++k) {
    unsigned lanes = 0;
    for (std::size_t i = 0; i < rows[k].count; ++i) {
      lanes |= unsigned{moved(rows[k], i) > tolerance} << i;
    }
    if (lanes != 0) open_.push_back({k, static_cast<LaneMask>(lanes)});
  }
}

int ContactConvergence::count_open() const {
  int sum = 0;
  for (const Open& open : open_) sum += std::popcount(open.lanes);
  return sum;
}

void ContactConvergence::keep_most_moved(std::span<const ContactRows> rows, int most) {
  const auto octave = [&](const Open& open, std::size_t i) {
    return octave_of(moved(rows[open.block], i));
  };
  octaves_.fill(0);
  for (const Open& open : open_) {
    for_lanes(open.lanes, [&](std::size_t i) { ++octaves_[octave(open, i)]; });
  }
  std::size_t lowest = octaves_.size();
  int sum = 0;
  while (lowest > 0 && sum + octaves_[lowest - 1] <= most) sum += octaves_[--lowest];
  for (Open& open : open_) {
    for_lanes(open.lanes, [&](std::size_t i) {
      if (octave(open, i) < lowest) open.lanes = static_cast<LaneMask>(open.lanes & ~(1u << i));
    });
  }
  std::erase_if(open_, [](const Open& open) { return open.lanes == 0; });
}

ContactConvergence::Outcome ContactConvergence::run(const Rule& rule,
                                                    const ContactOrder::Places& places,
                                                    bool reverse, std::span<ContactRows> rows,
                                                    const ContactKernels& kernels,
                                                    std::span<SolverBody> bodies) {
  Outcome outcome;
  const auto swept = rows.subspan(places.begin, places.end - places.begin);
  const auto solved = [&](const ContactRows& each) {
    return *std::max_element(each.change.begin(), each.change.end()) <= rule.tolerance;
  };
  if (rule.rows == 0 || std::all_of(swept.begin(), swept.end(), solved)) return outcome;
  moved_.assign(bodies.size(), 0.0f);
  for (const ContactRows& each : swept) note(each, lanes_in_use(each));
  const BodyNumbers numbers = numbers_of(bodies);
  for (;;) {
    find_open(places, rows, static_cast<float>(rule.tolerance));
    outcome.open = count_open();
    const int left = rule.rows - outcome.swept;
    if (left < rule.rows / kNotWorthIt) return outcome;
    if (outcome.open > left) keep_most_moved(rows, left);
    if (open_.empty()) return outcome;
    for (const auto& [block, lanes] : open_) {
      for_lanes(lanes, [&, &each = rows[block]](std::size_t i) {
        moved_[each.a[i]] = moved_[each.b[i]] = 0.0f;
      });
    }
    reverse = !reverse;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const Open& open = open_[reverse ? open_.size() - 1 - i : i];
      kernels.solve(rows[open.block], ContactPass::Motion, turns_of(rule.fresh), open.lanes,
                    numbers);
    }
    for (const auto& [block, lanes] : open_) note(rows[block], lanes);
    outcome.swept += count_open();
  }
}

}  // namespace tandem::pbd
