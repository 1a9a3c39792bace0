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

/// The order in which rows are swept: the sequence that is given, within each group, cut into
/// *levels*: a row's level is one above the highest of the earlier rows that share a movable body
/// with it. Rows of one level share no such body, so they may be solved in any order or at once,
/// with the same bits as one after the other. They lie in blocks of kLanes: those of one point by
/// themselves, cell by cell, as many as there are in each level, the last one filled up with kNone.
///
/// Large groups are divided among workers: blocks of near cells make up a part, and lie beside each
/// other. What is in a block has a say in what is swept on (ContactConvergence), so that it does
/// not depend on the number of workers. In which part a block is has none.
class ContactOrder {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// @param sequence  the order meant above     @param bodies  how many there are
  /// @param movers  see SubstepContext::movers     @param workers  that there are
  void build(std::span<const ContactLink> sequence, const ContactCells& cells, std::size_t bodies,
             std::span<const std::uint32_t> movers, std::uint32_t workers);
  /// `places(group)[kLanes * k + lane]` is the contact solved in that lane of block k of the group.
  std::span<const std::uint32_t> places(std::uint32_t group) const {
    if (group >= groups_.size()) return {};
    const Group& g = groups_[group];
    return std::span(places_).subspan(kLanes * g.begin, kLanes * (g.end - g.begin));
  }
  /// Rows of the group.
  int row_count(std::uint32_t group) const {
    return group < groups_.size() ? groups_[group].rows : 0;
  }
  /// Blocks by level; empty where they lie so.
  std::span<const std::uint32_t> by_level(std::uint32_t group) const {
    if (group >= groups_.size() || groups_[group].sweep == kNone) return {};
    const Group& g = groups_[group];
    return std::span(by_level_).subspan(g.begin, g.end - g.begin);
  }

  /// Call visit(block) for the rows of a group, forwards or backwards. Within a call nothing else
  /// has to do with the movable bodies of its rows.
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
    std::uint32_t first_level = 0;  ///< among those of all groups
    std::uint32_t sweep = kNone;    ///< into sweeps_; kNone: it is not divided
    int rows = 0;
  };

  void find_levels(std::span<const ContactLink> sequence, std::span<const std::uint32_t> movers);
  void lay_out(std::span<const ContactLink> sequence, const ContactCells& cells);
  void sort_by_cell(std::span<const ContactLink> sequence, const ContactCells& cells);
  void divide(Group& group, std::uint32_t parts, std::span<const ContactLink> sequence,
              const ContactCells& cells);

  void for_neighbours(std::span<const std::uint32_t> places, std::span<const ContactLink> sequence,
                      auto&& visit);
  /// Of the group's, by level.
  std::uint32_t first_block(const Group& group, std::uint32_t level) const {
    return first_blocks_[group.first_level + level] - group.begin;
  }

  /// First indices into the sequence, then contacts.
  std::vector<std::uint32_t> places_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> by_level_;  ///< by block of all groups; of those that are divided
  std::vector<PartSweep> sweeps_;        ///< of groups that are divided
  std::size_t sweeps_used_ = 0;
  /// By mover: the next free level, then the last block.
  detail::SparseArray<std::uint32_t> last_of_body_;
  std::vector<std::uint32_t> slots_;    ///< by contact: its level, then with its kind, into starts_
  std::vector<std::uint32_t> starts_;   ///< places, by level and kind
  std::vector<std::uint32_t> by_cell_;  ///< indices into the sequence
  std::vector<std::uint32_t> first_blocks_;  ///< by level of all groups
  // Scratch of divide(), by block as they lie by level:
  std::vector<std::uint32_t> begins_;  ///< by part
  std::vector<std::uint32_t> part_of_;
  std::vector<std::uint8_t> shares_;  ///< a body with another part
  std::vector<std::uint32_t> by_level_places_;
};

}  // namespace tandem::pbd
