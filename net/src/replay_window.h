// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

namespace tandem::net {

/// Which of the last 256 sequence numbers have been had. Ask before authentication, note after it:
/// a number that nobody has vouched for must not move the window.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 256;

  /// New: above all so far, or in the window and not had. 0 is no sequence number.
  bool fresh(std::uint64_t sequence) const {
    if (sequence == 0) return false;
    if (sequence > latest_) return true;
    // Differences, not sums: these do not overflow at the top of the range.
    return latest_ - sequence < kSize && !bit(sequence);
  }

  void note(std::uint64_t sequence) {
    if (sequence > latest_) {
      const std::uint64_t ahead = sequence - latest_;
      if (ahead >= kSize) {
        bits_.fill(0);
      } else {
        for (std::uint64_t i = 1; i <= ahead; ++i) word(latest_ + i) &= ~mask(latest_ + i);
      }
      latest_ = sequence;
    }
    word(sequence) |= mask(sequence);
  }

  /// The highest number noted, 0 where there is none.
  std::uint64_t latest() const { return latest_; }
  /// Bit i: whether latest() - 1 - i has been had.
  std::uint64_t before_latest() const {
    std::uint64_t out = 0;
    for (std::uint64_t i = 0; i < 64 && latest_ > i + 1; ++i) {
      if (bit(latest_ - 1 - i)) out |= std::uint64_t{1} << i;
    }
    return out;
  }

 private:
  static std::uint64_t mask(std::uint64_t sequence) { return std::uint64_t{1} << (sequence % 64); }
  std::uint64_t& word(std::uint64_t sequence) { return bits_[sequence % kSize / 64]; }
  bool bit(std::uint64_t sequence) const {
    return (bits_[sequence % kSize / 64] & mask(sequence)) != 0;
  }

  std::array<std::uint64_t, kSize / 64> bits_{};
  std::uint64_t latest_ = 0;
};

}  // namespace tandem::net
