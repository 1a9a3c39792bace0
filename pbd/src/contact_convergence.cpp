// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_convergence.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

#include "tandem/pbd/bit_cast.h"

namespace tandem::pbd {
namespace {

/// Of a positive speed: the exponent of its binary number.
std::uint8_t octave_of(float speed) {
  return static_cast<std::uint8_t>(bit_cast<std::uint32_t>(speed) >> 23);
}

/// The last of the budget is left over: looking for so few rows costs more than they bring.
constexpr int kNotWorthIt = 8;

}  // namespace

void ContactConvergence::note(const ContactRows& rows, LaneMask lanes) {
  for (std::size_t i = 0; i < rows.count; ++i) {
    if ((lanes >> i & 1u) == 0) continue;
    const auto speed = static_cast<float>(rows.change[i]);
    if (rows.a_moves >> i & 1u) moved_[rows.a[i]] = std::max(moved_[rows.a[i]], speed);
    if (rows.b_moves >> i & 1u) moved_[rows.b[i]] = std::max(moved_[rows.b[i]], speed);
  }
}

ContactConvergence::Open ContactConvergence::open_rows(const Ends& ends, float tolerance) const {
  float fastest = 0.0f;
  unsigned lanes = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float speed = std::max(moved_[ends.a[i]], moved_[ends.b[i]]);
    fastest = std::max(fastest, speed);
    if (!(speed > tolerance)) continue;
    for (std::size_t k = 0; k < kLanes; ++k) {
      lanes |= unsigned{ends.island[k] == ends.island[i]} << k;
    }
  }
  return {.lanes = static_cast<LaneMask>(lanes & ends.lanes), .octave = octave_of(fastest)};
}

void ContactConvergence::find_open(float tolerance) {
  open_.clear();
  octaves_.fill(0);
  for (std::uint32_t k = 0; k < ends_.size(); ++k) {
    Open open = open_rows(ends_[k], tolerance);
    if (open.lanes == 0) continue;
    open.block = k;
    open_.push_back(open);
    octaves_[open.octave] += std::popcount(open.lanes);
  }
}

int ContactConvergence::keep_most_moved(int most) {
  std::size_t lowest = octaves_.size();
  int kept = 0;
  while (lowest > 0 && kept + octaves_[lowest - 1] <= most) kept += octaves_[--lowest];
  std::erase_if(open_, [&](const Open& open) { return open.octave < lowest; });
  return kept;
}

void ContactConvergence::plan(const ContactOrder& order, std::uint32_t group) {
  plan_.clear();
  std::uint32_t begin = 0;
  for (std::uint32_t i = 1; i <= open_.size(); ++i) {
    const bool same = i < open_.size() &&
                      order.level(group, open_[i].block) == order.level(group, open_[begin].block);
    if (same) continue;
    plan_.add_level(begin, i);
    begin = i;
  }
}

ContactConvergence::Outcome ContactConvergence::run(const Rule& rule, const ContactOrder& order,
                                                    std::uint32_t group, bool reverse,
                                                    std::span<ContactRows> rows,
                                                    const ContactKernels& kernels,
                                                    std::span<SolverBody> bodies,
                                                    Workers& workers) {
  Outcome outcome;
  const auto solved = [&](const ContactRows& each) {
    return *std::max_element(each.change.begin(), each.change.end()) <= rule.tolerance;
  };
  if (rule.rows == 0 || std::all_of(rows.begin(), rows.end(), solved)) return outcome;
  moved_.resize(bodies.size());
  ends_.clear();
  for (const ContactRows& each : rows) {
    for (std::size_t i = 0; i < each.count; ++i) moved_[each.a[i]] = moved_[each.b[i]] = 0.0f;
  }
  for (const ContactRows& each : rows) {
    Ends& ends = ends_.emplace_back(Ends{each.a, each.b, {}, lanes_in_use(each)});
    for (std::size_t i = 0; i < kLanes; ++i) {
      ends.island[i] = bodies[(each.a_moves >> i & 1u) != 0 ? each.a[i] : each.b[i]].island;
    }
    note(each, kAllLanes);
  }
  const BodyNumbers numbers = numbers_of(bodies);
  for (;;) {
    find_open(static_cast<float>(rule.tolerance));
    outcome.open = std::accumulate(octaves_.begin(), octaves_.end(), 0);
    const int left = rule.rows - outcome.swept;
    if (left < rule.rows / kNotWorthIt) return outcome;
    const int kept = keep_most_moved(left);
    if (kept == 0) return outcome;
    for (const Open& open : open_) {
      const Ends& ends = ends_[open.block];
      for (std::size_t i = 0; i < kLanes; ++i) {
        if (open.lanes >> i & 1u) moved_[ends.a[i]] = moved_[ends.b[i]] = 0.0f;
      }
    }
    reverse = !reverse;
    plan(order, group);
    plan_.sweep(reverse, workers, [&](std::uint32_t i) {
      kernels.solve(rows[open_[i].block], ContactPass::Motion,
                    normal_friction_iterations(rule.first_substep), open_[i].lanes, numbers);
    });
    for (const Open& open : open_) note(rows[open.block], open.lanes);
    outcome.swept += kept;
  }
}

}  // namespace tandem::pbd
