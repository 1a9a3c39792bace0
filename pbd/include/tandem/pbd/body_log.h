// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/pbd/export.h"

namespace tandem::pbd {

/// Log of bodies that may move or have changed otherwise, so that caches of per-body data update
/// those only. A resting or sleeping body is logged once: when it is added, removed, woken, placed
/// or given another type.
class TANDEM_API BodyLog {
 public:
  /// How far a reader has read. An empty mark, or one of another world, has read nothing.
  struct Mark {
    std::shared_ptr<const std::byte> log = {};
    std::uint64_t count = 0;
    std::uint64_t stirred = 0;
  };

  /// @param slots  slots of the world: a log with more entries than that is dropped
  void note(std::uint32_t slot, std::size_t slots) {
    constexpr std::size_t kFewest = 1024;
    if (entries_.size() >= 2 * std::max(slots, kFewest)) outdate();
    if (name_ == nullptr) name_ = std::make_shared<const std::byte>();
    entries_.push_back(slot);
  }
  /// Reserves for a world of so many slots, so that later noting does not allocate.
  void reserve(std::size_t slots) {
    movers_.reserve(slots);
    listed_.reserve(slots);
  }
  /// Notes that a body is awake or moves.
  void stir() { ++stirred_; }
  /// Notes that every body may have changed.
  void outdate() {
    if (name_ == nullptr) name_ = std::make_shared<const std::byte>();
    base_ = count() + 1;
    entries_.clear();
    last_step_ = 0;
    all_new_ = true;
  }
  /// Ends a step: drops the entries that were there when the previous step ended.
  void end_step() {
    all_new_ = all_new_ || renewed_ < last_step_;
    renewed_ -= std::min(renewed_, last_step_);
    base_ += last_step_;
    entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(last_step_));
    last_step_ = entries_.size();
    // Building a scene logs all its bodies at once; that memory is given back.
    constexpr std::size_t kKeep = 4096;
    if (entries_.capacity() > kKeep && entries_.size() < kKeep / 4) {
      std::vector<std::uint32_t>(entries_).swap(entries_);
    }
  }
  /// Calls visit(slot) for every entry since the mark, some more than once.
  /// @return whether the log reaches back to the mark; if not, all bodies must be looked at
  bool read(Mark& mark, auto&& visit) const {
    const bool known = name_ != nullptr && mark.log == name_ && mark.count >= base_;
    const auto first = known ? static_cast<std::size_t>(mark.count - base_) : entries_.size();
    for (std::size_t i = first; i < entries_.size(); ++i) {
      visit(entries_[i]);
    }
    if (mark.log != name_) mark.log = name_;
    mark.count = count();
    mark.stirred = stirred_;
    return known;
  }
  /// Whether nothing was noted since the mark and no body stirred.
  bool is_quiet(const Mark& mark) const {
    return name_ != nullptr && mark.log == name_ && mark.count == count() &&
           mark.stirred == stirred_;
  }
  /// Slots of bodies that may move, ascending.
  /// @param moves  whether the body in a slot may move; asked for noted slots
  std::span<const std::uint32_t> movers(std::size_t slots, auto&& moves) {
    if (all_new_) {
      movers_.clear();
      listed_.assign(slots, 0);
      for (std::uint32_t i = 0; i < slots; ++i) list(i, moves(i));
    } else if (renewed_ < entries_.size()) {
      listed_.resize(slots, 0);
      const std::size_t before = movers_.size();
      bool gone = false;
      for (; renewed_ < entries_.size(); ++renewed_) {
        const std::uint32_t slot = entries_[renewed_];
        gone = gone || (listed_[slot] != 0 && !moves(slot));
        list(slot, moves(slot));
      }
      put_in_order(before, gone);
    }
    all_new_ = false;
    renewed_ = entries_.size();
    return movers_;
  }

 private:
  std::uint64_t count() const { return base_ + entries_.size(); }
  void list(std::uint32_t slot, bool moves) {
    if (moves && listed_[slot] == 0) movers_.push_back(slot);
    listed_[slot] = moves ? 1 : 0;
  }
  void put_in_order(std::size_t before, bool gone) {
    const auto new_ones = movers_.begin() + static_cast<std::ptrdiff_t>(before);
    std::sort(new_ones, movers_.end());
    std::inplace_merge(movers_.begin(), new_ones, movers_.end());
    if (!gone) return;
    // A body that left and returned is listed twice.
    movers_.erase(std::unique(movers_.begin(), movers_.end()), movers_.end());
    std::erase_if(movers_, [&](std::uint32_t slot) { return listed_[slot] == 0; });
  }

  std::shared_ptr<const std::byte> name_;  ///< identity of this log, kept alive by marks
  std::vector<std::uint32_t> entries_;     ///< slots
  std::uint64_t base_ = 0;                 ///< entries dropped from the front
  std::uint64_t stirred_ = 0;              ///< steps in which a body was awake or moved
  std::size_t last_step_ = 0;              ///< entries at the end of the last step
  std::vector<std::uint32_t> movers_;      ///< ascending
  std::vector<std::uint8_t> listed_;       ///< by slot: 1 = in movers_
  std::size_t renewed_ = 0;                ///< entries that movers_ includes
  bool all_new_ = true;                    ///< movers_ must be rebuilt
};

}  // namespace tandem::pbd
