// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "islands.h"

#include <algorithm>

namespace tandem::pbd {

// Union-find in place: an entry is the body's parent until build() replaces it by the root.
void Islands::build(std::span<const ConstraintEdge> edges, std::span<const std::uint32_t> movers,
                    std::span<const SolverBody> bodies) {
  island_of_.resize(bodies.size());
  for (const std::uint32_t i : movers) island_of_[i] = i;
  const auto moves = [&](std::uint32_t body) {
    return body != BodyId::kNone && bodies[body].inv_mass > 0.0;
  };
  for (const ConstraintEdge& edge : edges) {
    if (!moves(edge.body_a) || !moves(edge.body_b)) continue;
    const std::uint32_t root_a = root_of(edge.body_a);
    const std::uint32_t root_b = root_of(edge.body_b);
    if (root_a != root_b) island_of_[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }
  for (const std::uint32_t i : movers) island_of_[i] = root_of(i);
}

std::uint32_t Islands::root_of(std::uint32_t i) {
  while (island_of_[i] != i) {
    island_of_[i] = island_of_[island_of_[i]];
    i = island_of_[i];
  }
  return i;
}

}  // namespace tandem::pbd
