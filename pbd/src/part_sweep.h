// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "patience.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// Sweeps blocks of rows that are divided into parts, each from its first block to its last or
/// back. Blocks of two parts that share a body keep the order of a single thread: the later one
/// waits until the other part has passed the earlier one. There are no other waits and no barriers
/// within a sweep, and the bits are those of one thread.
/// Source: [saltz1991].
class PartSweep {
 public:
  static constexpr std::uint32_t kMaxParts = 64;

  /// Starts anew. @param begins  the first block of each part and the end of the last one
  void start(std::span<const std::uint32_t> begins);
  /// Declares that blocks of two parts share a body. All blocks must have a common order in which
  /// the earlier one comes first and each part's blocks ascend.
  void link(std::uint32_t earlier, std::uint32_t earlier_part, std::uint32_t later,
            std::uint32_t later_part);
  std::uint32_t parts() const { return static_cast<std::uint32_t>(parts_.size()); }

  /// Calls visit(block) for all blocks.
  template <class F>
  void run(bool reverse, Workers& workers, F&& visit) {
    for (std::uint32_t p = 0; p < parts(); ++p) {
      state_[p].at.store(reverse ? parts_[p].end : parts_[p].begin, std::memory_order_relaxed);
      state_[p].taken.store(0, std::memory_order_relaxed);
    }
    workers.for_each([&](int worker) {
      const auto own = static_cast<std::uint32_t>(worker) % parts();
      // Workers without a part of their own would only be in the way.
      const bool spare = static_cast<std::uint32_t>(worker) >= parts();
      Patience patience;
      std::uint32_t seen = 0;
      for (std::uint32_t left = blocks_left(reverse); left > 0; left = blocks_left(reverse)) {
        if (pass(own, reverse, visit)) continue;
        if (spare) return;
        // A worker may have been preempted only if there is no progress.
        if (left != std::exchange(seen, left)) patience.renew();
        patience.look();
      }
      if (worker == 0) workers.note_lost(patience.longest());
    });
  }

 private:
  /// Checks of another part's progress before a worker looks for another part to continue.
  static constexpr int kLooks = 256;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  struct Part {
    std::uint32_t begin = 0, end = 0;
  };
  /// Blocks that the other parts must have reached, by part: at least, when sweeping forwards; at
  /// most, backwards.
  struct Needs {
    std::uint32_t* forwards;
    std::uint32_t* back;
  };
  struct State {
    /// Forwards: the next block; backwards: the last block done.
    alignas(64) std::atomic<std::uint32_t> at{0};
    alignas(64) std::atomic<std::uint8_t> taken{0};  ///< a worker sweeps it
  };

  Needs needs(std::uint32_t block);
  std::uint32_t blocks_left(std::uint32_t p, bool reverse, std::memory_order order) const {
    const std::uint32_t at = state_[p].at.load(order);
    return reverse ? at - parts_[p].begin : parts_[p].end - at;
  }
  /// Acquires: a worker that sees 0 also sees the results of all parts.
  std::uint32_t blocks_left(bool reverse) const {
    std::uint32_t left = 0;
    for (std::uint32_t p = 0; p < parts(); ++p) {
      left += blocks_left(p, reverse, std::memory_order_acquire);
    }
    return left;
  }

  /// Continues all parts that no worker sweeps, its own first.
  /// @return whether a block was swept
  template <class F>
  bool pass(std::uint32_t own, bool reverse, F& visit) {
    bool any = false;
    for (std::uint32_t n = 0; n < parts(); ++n) {
      const std::uint32_t p = (own + n) % parts();
      if (blocks_left(p, reverse, std::memory_order_relaxed) == 0) continue;
      if (state_[p].taken.load(std::memory_order_relaxed) != 0 ||
          state_[p].taken.exchange(1, std::memory_order_acquire) != 0)
        continue;
      any = advance(p, reverse, visit) || any;
      state_[p].taken.store(0, std::memory_order_release);
    }
    return any;
  }

  /// Continues a part until it is done or waits for long.
  /// @return whether a block was swept
  template <class F>
  bool advance(std::uint32_t p, bool reverse, F& visit) {
    std::atomic<std::uint32_t>& at = state_[p].at;
    const Part part = parts_[p];
    const std::uint32_t first = at.load(std::memory_order_relaxed);
    const std::uint32_t last = reverse ? part.begin : part.end;
    std::uint32_t k = first;
    while (k != last) {
      const std::uint32_t block = reverse ? k - 1 : k;
      const std::uint32_t row = need_of_[block];
      if (row != kNone && !wait(row, reverse)) break;
      visit(block);
      k = reverse ? k - 1 : k + 1;
      if (row != kNone) at.store(k, std::memory_order_release);
    }
    at.store(k, std::memory_order_release);
    return k != first;
  }

  /// @return false on timeout
  bool wait(std::uint32_t row, bool reverse) const {
    const std::uint32_t* need =
        need_.data() + std::size_t{2} * row * parts() + (reverse ? parts() : 0);
    for (std::uint32_t q = 0; q < parts(); ++q) {
      const auto reached = [&] {
        const std::uint32_t at = state_[q].at.load(std::memory_order_acquire);
        return reverse ? at <= need[q] : at >= need[q];
      };
      if (need[q] == (reverse ? kNone : 0)) continue;
      for (int looks = 0; !reached(); ++looks) {
        if (looks == kLooks || state_[q].taken.load(std::memory_order_relaxed) == 0) {
          if (reached()) break;
          return false;
        }
        relax();
      }
    }
    return true;
  }

  std::vector<Part> parts_;
  std::vector<std::uint32_t> need_of_;  ///< by block: index into need_, or kNone
  std::vector<std::uint32_t> need_;     ///< twice one entry per part
  std::unique_ptr<State[]> state_ = std::make_unique<State[]>(kMaxParts);
};

}  // namespace tandem::pbd
