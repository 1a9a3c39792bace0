// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::nats {

/// Whether a peer keeps up with its messages. It receives its own presence: the delay through the
/// server and back is the delay of all other messages. Times in ns.
class Load {
 public:
  static constexpr std::int64_t kTooLate = 400'000'000;
  static constexpr std::int64_t kLook = 500'000'000;

  enum class Verdict : std::uint8_t { Wait, Slow, Well };

  void said(std::int64_t now) {
    if (waiting_since_ == kNever) waiting_since_ = now;
  }
  /// The presence sent at `sent` has come back.
  void heard(std::int64_t sent, std::int64_t now) {
    lag_ = now - sent;
    waiting_since_ = kNever;
    if (lag_ > worst_) worst_ = lag_;
  }
  std::int64_t lag() const { return lag_; }

  /// Call every kLook. @param dropped  messages so far  @param connected  to a server, all the time
  Verdict look(std::uint64_t dropped, bool connected, std::int64_t now) {
    if (now < next_) return Verdict::Wait;
    next_ = now + kLook;
    const bool lost = dropped > dropped_;
    dropped_ = dropped;
    if (!connected) {  // a peer that receives nothing is not slow
      waiting_since_ = kNever;
      worst_ = 0;
      return Verdict::Wait;
    }
    const bool waits = waiting_since_ != kNever && now - waiting_since_ > 2 * kTooLate;
    const bool late = worst_ > kTooLate;
    const bool heard = worst_ > 0;
    worst_ = 0;
    if (lost || late || waits) return Verdict::Slow;
    return heard ? Verdict::Well : Verdict::Wait;
  }

 private:
  static constexpr std::int64_t kNever = INT64_MIN;
  std::int64_t lag_ = -1;
  std::int64_t worst_ = 0;
  std::int64_t waiting_since_ = kNever;
  std::int64_t next_ = INT64_MIN;
  std::uint64_t dropped_ = 0;
};

}  // namespace tandem::nats
