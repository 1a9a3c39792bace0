// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact_cells.h"
#include "contact_rows.h"
#include "contact_support.h"
#include "part_sweep.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// The order in which rows are swept. Within each group the given sequence is cut into *levels*: a
/// row's level is one above the highest of the earlier rows that share a movable body with it. Rows
/// of one level share no such body, so they may be solved in any order or at once, with the same
/// bits as one after the other. They are stored in blocks of kLanes, single points and faces apart,
/// sorted by cell; the last block of a level is filled up with kNone.
///
/// Large groups are divided among workers: blocks of near cells form a part and are stored next to
/// each other. ContactConvergence depends on the rows of a block, so blocks do not depend on the
/// number of workers. It does not depend on the parts.
class ContactOrder {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// @param sequence  see above     @param bodies  number of bodies
  /// @param movers  see SubstepContext::movers     @param workers  number of workers
  void build(std::span<const ContactLink> sequence, const ContactCells& cells, std::size_t bodies,
             std::span<const std::uint32_t> movers, std::uint32_t workers);
  /// `places(group)[kLanes * k + lane]` is the contact in that lane of block k of the group.
  std::span<const std::uint32_t> places(std::uint32_t group) const {
    if (group >= groups_.size()) return {};
    const Group& g = groups_[group];
    return std::span(places_).subspan(kLanes * g.begin, kLanes * (g.end - g.begin));
  }
  /// Number of rows of the group.
  int row_count(std::uint32_t group) const {
    return group < groups_.size() ? groups_[group].rows : 0;
  }
  /// Blocks by level; empty if that is their order.
  std::span<const std::uint32_t> by_level(std::uint32_t group) const {
    if (group >= groups_.size() || groups_[group].sweep == kNone) return {};
    const Group& g = groups_[group];
    return std::span(by_level_).subspan(g.begin, g.end - g.begin);
  }

  /// Calls visit(block) for the rows of a group, forwards or backwards. During a call no other
  /// thread uses the movable bodies of its rows.
  void sweep(std::uint32_t group, bool reverse, Workers& workers, auto&& visit) {
    if (group >= groups_.size()) return;
    const Group& g = groups_[group];
    if (g.sweep != kNone) {
      sweeps_[g.sweep].run(reverse, workers, visit);
      return;
    }
    const std::uint32_t count = g.end - g.begin;
    for (std::uint32_t k = 0; k < count; ++k) visit(reverse ? count - 1 - k : k);
  }

 private:
  struct Group {
    std::uint32_t begin = 0, end = 0;  ///< blocks
    std::uint32_t levels = 0;
    std::uint32_t first_level = 0;  ///< index among those of all groups
    std::uint32_t sweep = kNone;    ///< index into sweeps_; kNone: not divided
    int rows = 0;
  };

  void find_levels(std::span<const ContactLink> sequence, std::span<const std::uint32_t> movers);
  void lay_out(std::span<const ContactLink> sequence, const ContactCells& cells);
  void sort_by_cell(std::span<const ContactLink> sequence, const ContactCells& cells);
  void divide(Group& group, std::uint32_t parts, std::span<const ContactLink> sequence,
              const ContactCells& cells);

  void for_neighbours(std::span<const std::uint32_t> places, std::span<const ContactLink> sequence,
                      auto&& visit);
  /// Index in the group of a level's first block.
  std::uint32_t first_block(const Group& group, std::uint32_t level) const {
    return first_blocks_[group.first_level + level] - group.begin;
  }

  /// At first indices into the sequence, finally contacts.
  std::vector<std::uint32_t> places_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> by_level_;  ///< by block of all groups; only for divided ones
  std::vector<PartSweep> sweeps_;        ///< of divided groups
  std::size_t sweeps_used_ = 0;
  /// By mover: the next free level, then the last block.
  detail::SparseArray<std::uint32_t> last_of_body_;
  std::vector<std::uint32_t> slots_;         ///< by contact: level, then an index into starts_
  std::vector<std::uint32_t> starts_;        ///< places, by level and kind
  std::vector<std::uint32_t> by_cell_;       ///< indices into the sequence
  std::vector<std::uint32_t> first_blocks_;  ///< by level of all groups
  // Scratch of divide(), by block in level order:
  std::vector<std::uint32_t> begins_;  ///< by part
  std::vector<std::uint32_t> part_of_;
  std::vector<std::uint8_t> shares_;  ///< it shares a body with another part
  std::vector<std::uint32_t> by_level_places_;
};

}  // namespace tandem::pbd
