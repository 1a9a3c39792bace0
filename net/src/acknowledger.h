// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "channel_wire.h"
#include "replay_window.h"
#include "rtt.h"

namespace tandem::net {

/// Which packets have been received, and when that has to be acknowledged. Times in ns.
class Acknowledger {
 public:
  /// @param wants_ack  whether the other end keeps some of its contents until it is acknowledged
  void note(std::uint64_t sequence, bool wants_ack, std::int64_t now) {
    if (sequence > received_.latest()) latest_at_ = now;
    if (received_.fresh(sequence)) received_.note(sequence);
    if (!wants_ack) return;
    ++unacknowledged_;
    due_ = unacknowledged_ >= kEvery ? now : std::min(due_, now + kDelay);
  }

  /// Latest time of the next acknowledgement, INT64_MAX if none is due.
  std::int64_t due() const { return due_; }

  /// Appends a packet's header with the acknowledgements.
  void write(std::int64_t now, std::vector<std::byte>& out) {
    ChannelHeader header;
    if (received_.latest() != 0) {
      header.ack = static_cast<std::uint32_t>(received_.latest());
      header.ack_bits = received_.before_latest();
      header.ack_delay = static_cast<std::uint16_t>(
          std::clamp<std::int64_t>((now - latest_at_) / kAckDelayUnit, 0, 0xffff));
    }
    encode(header, out);
    unacknowledged_ = 0;
    due_ = INT64_MAX;
  }

  /// Time since the latest packet came; kNoClockDelay if unknown or too long.
  std::uint32_t clock_delay(std::int64_t now) const {
    const std::int64_t delay = now - latest_at_;
    const bool known = received_.latest() != 0 && delay >= 0 && delay < std::int64_t{kNoClockDelay};
    return known ? static_cast<std::uint32_t>(delay) : kNoClockDelay;
  }

 private:
  static constexpr std::int64_t kDelay = RttEstimate::kMaxAckDelay;  // a state carries it sooner
  static constexpr int kEvery = 8;                                   // packets

  ReplayWindow received_;
  std::int64_t latest_at_ = 0;
  int unacknowledged_ = 0;
  std::int64_t due_ = INT64_MAX;
};

}  // namespace tandem::net
