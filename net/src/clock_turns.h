// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

namespace tandem::net {

/// When to send the local clock to the other end of a connection: in a packet that leaves anyway,
/// or alone, more often at the beginning. Never before begin(). Times in ns.
class ClockTurns {
 public:
  explicit ClockTurns(std::int64_t now) : opened_(now) {}

  void begin(std::int64_t now) {
    if (last_ == INT64_MIN) last_ = now - kAlone;
  }
  void told(std::int64_t now) { last_ = now; }

  bool is_due_alone(std::int64_t now) const { return now - last_ >= period(now); }
  bool rides(std::int64_t now) const { return now - last_ >= kRides; }
  std::int64_t next_due(std::int64_t now) const {
    return last_ == INT64_MIN ? INT64_MAX : last_ + period(now);
  }

 private:
  static constexpr std::int64_t kRides = 45'000'000;
  static constexpr std::int64_t kAlone = 250'000'000;
  static constexpr std::int64_t kFirst = 25'000'000;
  static constexpr std::int64_t kFirstFor = 1'500'000'000;

  std::int64_t period(std::int64_t now) const {
    return now - opened_ < kFirstFor ? kFirst : kAlone;
  }

  std::int64_t opened_;
  std::int64_t last_ = INT64_MIN;
};

}  // namespace tandem::net
