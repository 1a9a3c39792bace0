// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tandem/pbd/contact.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

/// Contacts come last in each sweep, so that non-penetration wins.
inline bool is_last(const ConstraintBlock& block) {
  return block.order() >= static_cast<int>(SolveOrder::Contact);
}

/// The edges of all rows of a world; memory is reused.
class ConstraintEdges {
 public:
  void list(const World& world) {
    edges_.clear();
    idle_.clear();
    single_.clear();
    names_all_ = true;
    projecting_ = 0;
    for (const auto& block : world.blocks()) {
      if (block.get() == world.contacts()) continue;
      const std::size_t before = edges_.size();
      const std::size_t idle_before = idle_.size();
      block->append_edges(edges_);
      block->append_idle(idle_);
      if (!block->groups_at_once()) {
        single_.insert(single_.end(), edges_.begin() + static_cast<std::ptrdiff_t>(before),
                       edges_.end());
        single_.insert(single_.end(), idle_.begin() + static_cast<std::ptrdiff_t>(idle_before),
                       idle_.end());
        names_all_ =
            names_all_ && (block->empty() || edges_.size() > before || idle_.size() > idle_before);
      }
      if (!is_last(*block)) projecting_ = edges_.size();
    }
    contacts_ = edges_.size();
    if (world.contacts() != nullptr) world.contacts()->append_edges(edges_);
  }
  std::span<const ConstraintEdge> all() const { return edges_; }
  /// Edges of inactive rows.
  std::span<const ConstraintEdge> idle() const { return idle_; }
  /// Edges of blocks that project poses: those before contacts, which come first.
  std::span<const ConstraintEdge> projecting() const { return all().first(projecting_); }
  std::span<const ConstraintEdge> without_contacts() const { return all().first(contacts_); }
  /// Edges of blocks that do not allow several groups at once.
  std::span<const ConstraintEdge> of_single_groups() const { return single_; }
  /// Whether each of those blocks has named bodies: one without edges may act on any body.
  bool names_all() const { return names_all_; }

 private:
  std::vector<ConstraintEdge> edges_;
  std::vector<ConstraintEdge> idle_;
  std::vector<ConstraintEdge> single_;
  std::size_t projecting_ = 0;
  std::size_t contacts_ = 0;
  bool names_all_ = true;
};

}  // namespace tandem::pbd
