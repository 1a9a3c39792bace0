// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>

namespace tandem::pbd {

/// What one member may have others do: so much a second, and so much at once where it has been
/// quiet. A token bucket that may go below zero, so that what is not known before it is done can be
/// paid for afterwards. Times in ns, of any clock; one that goes back is no income.
class TokenBucket {
 public:
  /// s: who has been over it for so long is not in a hurry, but does harm.
  static constexpr std::int64_t kPatience = 2'000'000'000;

  TokenBucket() = default;
  TokenBucket(double per_second, double burst) : tokens_(burst) { set(per_second, burst); }

  void set(double per_second, double burst) {
    per_second_ = per_second;
    burst_ = burst;
    tokens_ = std::min(tokens_, burst);
  }

  /// Whether there is anything left now. Where not, that counts as a refusal.
  bool admits(std::int64_t now) {
    if (fill(now)) return true;
    if (refused_ == 0 || now - last_refused_ > kPatience / 4) over_since_ = now;
    last_refused_ = now;
    ++refused_;
    return false;
  }
  /// The same without counting.
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
  /// It has been dropped for that, and begins anew.
  void forgive() { last_refused_ = over_since_; }
  /// Refused again and again for kPatience, up to the last time.
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
