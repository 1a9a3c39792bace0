// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "contact_support.h"

#include <algorithm>
#include <cstddef>

#include "contact_order.h"

namespace tandem::pbd {
namespace {

/// Of a body that nothing holds up: their order tells nothing.
constexpr std::uint32_t kFar = 0xffffffff;

}  // namespace

std::span<const std::uint32_t> ContactSupport::arrange(std::span<const Contact> contacts,
                                                       std::span<const std::uint32_t> sequence,
                                                       std::span<const SolverBody> bodies) {
  awake_.clear();
  for (std::size_t n = 0; n < contacts.size(); ++n) {
    const auto i = sequence.empty() ? static_cast<std::uint32_t>(n) : sequence[n];
    if (group_of(contacts[i], bodies) != SolverBody::kNoGroup) awake_.push_back(i);
  }
  link(contacts, bodies);
  const std::uint32_t farthest = measure();
  // Counting sort by the sum of both distances; equal ones stay in sequence.
  const auto rank = [&](std::uint32_t i) {
    const Manifold& m = contacts[i].manifold;
    return std::min(distance_[m.body_a], farthest + 1) +
           std::min(distance_[m.body_b], farthest + 1);
  };
  start_.assign(2 * std::size_t{farthest} + 4, 0);
  for (const std::uint32_t i : awake_) ++start_[rank(i) + 1];
  for (std::size_t r = 1; r < start_.size(); ++r) start_[r] += start_[r - 1];
  places_.resize(awake_.size());
  for (const std::uint32_t i : awake_) places_[start_[rank(i)]++] = i;
  return places_;
}

/// Who touches whom, and whose distance is known from the start.
void ContactSupport::link(std::span<const Contact> contacts, std::span<const SolverBody> bodies) {
  distance_.assign(bodies.size(), kFar);
  first_.assign(bodies.size() + 1, 0);
  queue_.clear();
  const auto moves = [&](std::uint32_t body) { return bodies[body].inv_mass > 0.0; };
  for (const std::uint32_t i : awake_) {
    const std::uint32_t a = contacts[i].manifold.body_a;
    const std::uint32_t b = contacts[i].manifold.body_b;
    if (moves(a) && moves(b)) {
      ++first_[a + 1];
      ++first_[b + 1];
      continue;
    }
    for (const std::uint32_t body : {a, b}) {
      if (!moves(body)) {
        distance_[body] = 0;
      } else if (distance_[body] != 1) {
        distance_[body] = 1;
        queue_.push_back(body);
      }
    }
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  neighbours_.resize(first_.back());
  for (const std::uint32_t i : awake_) {
    const std::uint32_t a = contacts[i].manifold.body_a;
    const std::uint32_t b = contacts[i].manifold.body_b;
    if (!moves(a) || !moves(b)) continue;
    neighbours_[first_[a]++] = b;
    neighbours_[first_[b]++] = a;
  }
  // Each has run on to where the next one begins.
  for (std::size_t i = first_.size() - 1; i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
}

/// Breadth first: distances do not depend on the order of the queue.
std::uint32_t ContactSupport::measure() {
  std::uint32_t farthest = 0;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const std::uint32_t body = queue_[head];
    farthest = distance_[body];
    for (std::uint32_t n = first_[body]; n < first_[body + 1]; ++n) {
      if (distance_[neighbours_[n]] != kFar) continue;
      distance_[neighbours_[n]] = farthest + 1;
      queue_.push_back(neighbours_[n]);
    }
  }
  return farthest;
}

}  // namespace tandem::pbd
