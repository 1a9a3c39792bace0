// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

namespace tandem::net {

/// Which of the last 256 sequence numbers were received. Check before authentication, record after
/// it: an unauthenticated number must not move the window.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 256;

  /// Above all so far, or in the window and not received. 0 is no sequence number.
  bool fresh(std::uint64_t sequence) const {
    if (sequence == 0) return false;
    if (sequence > latest_) return true;
    // Differences do not overflow at the top of the range; sums would.
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

  /// The highest number recorded, 0 if there is none.
  std::uint64_t latest() const { return latest_; }
  /// Bit i: whether latest() - 1 - i was received.
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
