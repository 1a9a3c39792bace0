// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::net {

/// Round trip of one link, ns: smoothed, with its variation, as in RFC 6298, and its recent
/// minimum.
class RttEstimate {
 public:
  static constexpr std::int64_t kInitialTimeout = 500'000'000;
  static constexpr std::int64_t kMinTimeout = 100'000'000;
  /// Longest delay of the other end's acknowledgements; subtracted from samples.
  static constexpr std::int64_t kMaxAckDelay = 25'000'000;
  static constexpr std::int64_t kMaxTimeout = 3'000'000'000;
  static constexpr std::int64_t kBaseWindow = 10'000'000'000;

  void add(std::int64_t sample, std::int64_t now) {
    sample = std::clamp<std::int64_t>(sample, 0, 60'000'000'000);
    recent_[count_++ % recent_.size()] = sample;
    if (!any_) {
      any_ = true;
      smoothed_ = least_ = previous_least_ = sample;
      spread_ = sample / 2;
      window_start_ = now;
      return;
    }
    spread_ += (std::max(smoothed_ - sample, sample - smoothed_) - spread_) / 4;
    smoothed_ += (sample - smoothed_) / 8;
    // Minimum of the last one to two windows: the round trip without queues.
    if (now - window_start_ >= kBaseWindow) {
      previous_least_ = now - window_start_ >= 2 * kBaseWindow ? sample : least_;
      least_ = sample;
      window_start_ = now;
    }
    least_ = std::min(least_, sample);
  }

  bool any() const { return any_; }
  std::int64_t smoothed() const { return smoothed_; }
  /// Minimum of the last 16: reduces jitter.
  std::int64_t recent() const {
    const auto end =
        recent_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, recent_.size()));
    return count_ == 0 ? 0 : *std::min_element(recent_.begin(), end);
  }
  std::int64_t base() const { return std::min(least_, previous_least_); }
  /// Time after which an unacknowledged packet counts as lost.
  std::int64_t timeout() const {
    if (!any_) return kInitialTimeout;
    return std::clamp(smoothed_ + 4 * spread_ + kMaxAckDelay, kMinTimeout, kMaxTimeout);
  }

 private:
  bool any_ = false;
  std::int64_t smoothed_ = 0;
  std::int64_t spread_ = 0;
  std::array<std::int64_t, 16> recent_{};
  std::size_t count_ = 0;
  std::int64_t least_ = 0;
  std::int64_t previous_least_ = 0;
  std::int64_t window_start_ = 0;
};

}  // namespace tandem::net
