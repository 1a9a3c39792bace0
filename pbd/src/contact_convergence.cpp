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

/// Binary exponent of a positive speed.
std::uint8_t octave_of(float speed) {
  return static_cast<std::uint8_t>(bit_cast<std::uint32_t>(speed) >> 23);
}

/// Blocks per chunk of a worker.
constexpr std::size_t kBlockGrain = 64;

/// The last part of the budget is left unused: searching costs more than so few rows bring.
constexpr int kNotWorthIt = 8;

}  // namespace

void ContactConvergence::reserve(std::size_t blocks, std::size_t bodies) {
  moved_.resize(bodies);
  ends_.reserve(blocks);
  open_.reserve(blocks);
}

ContactConvergence::Ends ContactConvergence::ends_of(const ContactRows& rows,
                                                     std::span<const SolverBody> bodies) {
  Ends ends{rows.a, rows.b, {}, lanes_in_use(rows)};
  for (std::size_t i = 0; i < kLanes; ++i) {
    if ((rows.a_moves >> i & 1u) == 0) ends.a[i] = rows.b[i];
    if ((rows.b_moves >> i & 1u) == 0) ends.b[i] = rows.a[i];
    ends.island[i] = bodies[ends.a[i]].island;
  }
  return ends;
}

void ContactConvergence::note(std::uint32_t block, const ContactRows& rows, LaneMask lanes) {
  const Ends& ends = ends_[block];
  for (std::size_t i = 0; i < rows.count; ++i) {
    if ((lanes >> i & 1u) == 0) continue;
    const auto speed = static_cast<float>(rows.change[i]);
    for (const std::uint32_t body : {ends.a[i], ends.b[i]}) {
      Moved& moved = moved_[body];
      const float before = moved.sweep == sweep_ ? moved.speed : 0.0f;
      moved = {std::max(before, speed), sweep_};
    }
  }
}

ContactConvergence::Open ContactConvergence::open_rows(const Ends& ends, float tolerance) const {
  float fastest = 0.0f;
  unsigned lanes = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const float speed = std::max(moved_[ends.a[i]].speed, moved_[ends.b[i]].speed);
    fastest = std::max(fastest, speed);
    if (!(speed > tolerance)) continue;
    for (std::size_t k = 0; k < kLanes; ++k) {
      lanes |= unsigned{ends.island[k] == ends.island[i]} << k;
    }
  }
  return {.lanes = static_cast<LaneMask>(lanes & ends.lanes), .octave = octave_of(fastest)};
}

void ContactConvergence::find_open(float tolerance, Workers& workers) {
  workers.for_chunks(ends_.size(), kBlockGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) open_[k] = open_rows(ends_[k], tolerance);
  });
  octaves_.fill(0);
  for (const Open& open : open_) octaves_[open.octave] += std::popcount(open.lanes);
}

int ContactConvergence::keep_most_moved(int most, std::size_t& lowest) const {
  lowest = octaves_.size();
  int kept = 0;
  while (lowest > 0 && kept + octaves_[lowest - 1] <= most) kept += octaves_[--lowest];
  return kept;
}

ContactConvergence::Outcome ContactConvergence::run(const Rule& rule, ContactOrder& order,
                                                    std::uint32_t group, bool reverse,
                                                    std::span<ContactRows> rows,
                                                    const ContactKernels& kernels,
                                                    std::span<SolverBody> bodies,
                                                    Workers& workers) {
  Outcome outcome;
  const auto any_open = [&](std::size_t begin, std::size_t end) {
    return std::any_of(rows.begin() + begin, rows.begin() + end, [&](const ContactRows& each) {
      return !(*std::max_element(each.change.begin(), each.change.end()) <= rule.tolerance);
    });
  };
  if (rule.rows == 0 || !workers.any_chunk(rows.size(), kBlockGrain, any_open)) return outcome;
  moved_.resize(bodies.size());
  ends_.resize(rows.size());
  open_.resize(rows.size());
  workers.for_chunks(rows.size(), kBlockGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) ends_[k] = ends_of(rows[k], bodies);
  });
  ++sweep_;
  order.sweep(group, false, workers, [&](std::uint32_t k) { note(k, rows[k], kAllLanes); });
  const BodyNumbers numbers = numbers_of(bodies);
  for (int sweep = 0;; ++sweep) {
    find_open(static_cast<float>(rule.tolerance), workers);
    outcome.open = std::accumulate(octaves_.begin(), octaves_.end(), 0);
    if (sweep == rule.sweeps) return outcome;
    const int left = rule.rows - outcome.swept;
    if (left < rule.rows / kNotWorthIt) return outcome;
    std::size_t lowest = 0;
    const int kept = keep_most_moved(left, lowest);
    if (kept == 0) return outcome;
    reverse = !reverse;
    ++sweep_;
    order.sweep(group, reverse, workers, [&](std::uint32_t k) {
      const Open& open = open_[k];
      if (open.lanes == 0 || open.octave < lowest) return;
      kernels.solve(rows[k], ContactPass::Motion, normal_friction_iterations(rule.first_substep),
                    open.lanes, numbers);
      note(k, rows[k], open.lanes);
    });
    outcome.swept += kept;
  }
}

}  // namespace tandem::pbd
