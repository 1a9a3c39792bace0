// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/constraint.h"

namespace tandem::pbd {

void ConstraintBlock::append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const {
  std::vector<ConstraintEdge> edges;
  append_edges(edges);
  for (const ConstraintEdge& edge : edges) {
    if (edge.body_a == body && edge.body_b != BodyId::kNone) joined.push_back(edge.body_b);
    if (edge.body_b == body && edge.body_a != BodyId::kNone) joined.push_back(edge.body_a);
  }
}

}  // namespace tandem::pbd
