// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact_rows.h"
#include "contact_support.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// The order in which rows are swept: the sequence that is given, within each group, cut into
/// *levels*: a row's level is one above the highest of the earlier rows that share a movable body
/// with it. Rows of one level share no such body, so they may be solved in any order or at once,
/// with the same bits as one after the other. They lie in blocks of kLanes: those of one point by
/// themselves, as many as there are in each level, the last one filled up with kNone.
class ContactOrder {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// `places()[kLanes * k + lane]` is the contact solved in that lane of block k.
  /// @param sequence  the order meant above     @param bodies  how many there are
  void build(std::span<const ContactLink> sequence, std::size_t bodies);
  std::span<const std::uint32_t> places() const { return places_; }

  /// Call visit(block) for the rows of a group, forwards or backwards.
  template <class Visit>
  void sweep(std::uint32_t group, bool reverse, Workers& workers, Visit&& visit) const {
    if (group >= groups_.size()) return;
    const Group& range = groups_[group];
    if (workers.count() == 1 || !range.wide) {
      const std::uint32_t n = range.end - range.begin;
      for (std::uint32_t k = 0; k < n; ++k) visit(reverse ? range.end - 1 - k : range.begin + k);
      return;
    }
    workers.run([&](int worker) {
      const auto count = static_cast<std::uint32_t>(workers.count());
      const auto me = static_cast<std::uint32_t>(worker);
      const std::uint32_t runs = range.last_run - range.first_run;
      for (std::uint32_t r = 0; r < runs; ++r) {
        const Run& run = runs_[reverse ? range.last_run - 1 - r : range.first_run + r];
        const std::uint32_t n = run.end - run.begin;
        if (run.wide) {
          const std::uint32_t from = run.begin + n * me / count;
          const std::uint32_t to = run.begin + n * (me + 1) / count;
          for (std::uint32_t k = from; k < to; ++k) visit(k);
        } else if (me == 0) {
          for (std::uint32_t k = 0; k < n; ++k) visit(reverse ? run.end - 1 - k : run.begin + k);
        }
        workers.meet();
      }
    });
  }
  struct Places {
    std::uint32_t begin = 0;  ///< blocks
    std::uint32_t end = 0;
  };
  /// The blocks of a group.
  Places range(std::uint32_t group) const {
    if (group >= groups_.size()) return {};
    return {groups_[group].begin, groups_[group].end};
  }

 private:
  /// A level wide enough to be shared out, or several narrow ones that one worker sweeps.
  struct Run {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    bool wide = false;
  };
  struct Group {
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t first_run = 0;
    std::uint32_t last_run = 0;
    bool wide = false;  ///< has a run worth sharing
  };

  void add_run(std::uint32_t begin, std::uint32_t end, Group& group);

  std::vector<std::uint32_t> places_;
  std::vector<Group> groups_;
  std::vector<Run> runs_;
  std::vector<std::uint32_t> level_of_body_;
  std::vector<std::uint32_t> slots_;  ///< by contact: group, level and kind, an index into starts_
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> level_count_;  ///< by group
  std::vector<std::uint32_t> first_level_;  ///< by group, into starts_
};

}  // namespace tandem::pbd
