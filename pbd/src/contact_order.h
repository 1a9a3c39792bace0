// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact_rows.h"
#include "contact_support.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// A sweep, cut into stages that workers share, and stages into chunks that anyone may take.
class SweepPlan {
 public:
  void clear();
  /// What may be visited in any order or at once, after the levels before.
  void add_level(std::uint32_t begin, std::uint32_t end);

  /// Call visit(i) for all levels, forwards or backwards.
  void sweep(bool reverse, Workers& workers, auto&& visit) const {
    workers.run(starts_, reverse, [&](std::uint32_t chunk, int) {
      const Chunk& c = chunks_[chunk];
      for (std::uint32_t i = 0; i < c.end - c.begin; ++i) {
        visit(reverse ? c.end - 1 - i : c.begin + i);
      }
    });
  }

 private:
  struct Chunk {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
  };
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> starts_{0};  ///< chunks before each stage, and all
  bool open_ = false;  ///< the last stage is one chunk, which further narrow levels may join
};

/// The order in which rows are swept: the sequence that is given, within each group, cut into
/// *levels*: a row's level is one above the highest of the earlier rows that share a movable body
/// with it. Rows of one level share no such body, so they may be solved in any order or at once,
/// with the same bits as one after the other. They lie in blocks of kLanes: those of one point by
/// themselves, as many as there are in each level, the last one filled up with kNone.
class ContactOrder {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// @param sequence  the order meant above     @param bodies  how many there are
  /// @param movers  see SubstepContext::movers
  void build(std::span<const ContactLink> sequence, std::size_t bodies,
             std::span<const std::uint32_t> movers);
  /// `places(group)[kLanes * k + lane]` is the contact solved in that lane of block k of the group.
  std::span<const std::uint32_t> places(std::uint32_t group) const {
    if (group >= groups_) return {};
    const std::size_t begin = first_block_[first_level_[group]];
    const std::size_t end = first_block_[first_level_[group + 1]];
    return std::span(places_).subspan(kLanes * begin, kLanes * (end - begin));
  }

  /// Call visit(block) for the rows of a group, forwards or backwards.
  void sweep(std::uint32_t group, bool reverse, Workers& workers, auto&& visit) const {
    if (group < groups_) plans_[group].sweep(reverse, workers, visit);
  }
  /// The level of a block of a group.
  std::uint32_t level(std::uint32_t group, std::uint32_t block) const {
    return level_of_block_[first_block_[first_level_[group]] + block];
  }

 private:
  std::vector<std::uint32_t> places_;
  std::size_t groups_ = 0;
  std::vector<SweepPlan> plans_;  ///< by group
  detail::SparseArray<std::uint32_t> level_of_body_;
  std::vector<std::uint32_t> slots_;  ///< by contact: group, level and kind, an index into starts_
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> level_count_;     ///< by group
  std::vector<std::uint32_t> first_level_;     ///< by group
  std::vector<std::uint32_t> first_block_;     ///< by level of all groups
  std::vector<std::uint32_t> level_of_block_;  ///< of all groups
};

}  // namespace tandem::pbd
