// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>

namespace tandem::pbd {

/// Rate limit for the work that one member may cause at others: an amount per second, with a burst
/// after a quiet time. A token bucket that may go below zero, so that costs known only afterwards
/// can be charged. Times in ns, of any clock; a clock that goes back adds nothing.
class TokenBucket {
 public:
  /// s: a sender that exceeds its rate for longer than this is abusive, not just in a hurry.
  static constexpr std::int64_t kPatience = 2'000'000'000;

  TokenBucket() = default;
  TokenBucket(double per_second, double burst) : tokens_(burst) { set(per_second, burst); }

  void set(double per_second, double burst) {
    per_second_ = per_second;
    burst_ = burst;
    tokens_ = std::min(tokens_, burst);
  }

  /// Whether tokens are left now. If not, it counts as a refusal.
  bool admits(std::int64_t now) {
    if (fill(now)) return true;
    if (refused_ == 0 || now - last_refused_ > kPatience / 4) over_since_ = now;
    last_refused_ = now;
    ++refused_;
    return false;
  }
  /// Refills; like admits(), but counts no refusal.
  bool fill(std::int64_t now) {
    if (started_ && now > at_) {
      tokens_ = std::min(burst_, tokens_ + per_second_ * 1e-9 * static_cast<double>(now - at_));
    }
    started_ = true;
    at_ = now;
    return tokens_ > 0.0;
  }
  void spend(double tokens) { tokens_ -= tokens; }

  std::uint64_t refused() const { return refused_; }
  /// The member was dropped as abusive; start anew.
  void forgive() { last_refused_ = over_since_; }
  /// Whether refusals have gone on for kPatience, up to the last one.
  bool abused() const { return refused_ > 0 && last_refused_ - over_since_ >= kPatience; }

 private:
  double per_second_ = 0.0;
  double burst_ = 0.0;
  double tokens_ = 0.0;
  bool started_ = false;
  std::int64_t at_ = 0;
  std::int64_t over_since_ = 0;
  std::int64_t last_refused_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace tandem::pbd
