// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "islands.h"

#include <algorithm>

namespace tandem::pbd {

/// Union-find in place: a body's entry is its parent until build() has made it the root.
class Islands::Joiner final : public LinkVisitor {
 public:
  Joiner(std::vector<std::uint32_t>& parents, std::span<const SolverBody> bodies)
      : parents_(parents), bodies_(bodies) {}
  void link(std::uint32_t a, std::uint32_t b) override {
    if (a == BodyId::kNone || b == BodyId::kNone) return;
    if (bodies_[a].inv_mass == 0.0 || bodies_[b].inv_mass == 0.0) return;
    const std::uint32_t ra = root_of(a);
    const std::uint32_t rb = root_of(b);
    if (ra != rb) parents_[std::max(ra, rb)] = std::min(ra, rb);
  }
  std::uint32_t root_of(std::uint32_t i) {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

 private:
  std::vector<std::uint32_t>& parents_;
  std::span<const SolverBody> bodies_;
};

void Islands::build(std::span<const std::unique_ptr<ConstraintBlock>> blocks,
                    std::span<const SolverBody> bodies) {
  const auto count = static_cast<std::uint32_t>(bodies.size());
  island_of_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) island_of_[i] = i;
  Joiner joiner(island_of_, bodies);
  for (const auto& block : blocks) {
    if (!block->empty()) block->links(joiner);
  }
  for (std::uint32_t i = 0; i < count; ++i) island_of_[i] = joiner.root_of(i);
}

}  // namespace tandem::pbd
