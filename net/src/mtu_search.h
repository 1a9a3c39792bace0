// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tandem::net {

/// How long datagrams may be on one way: RFC 8899 (DPLPMTUD), docs/protocol.md. Probes are padded
/// packets that are acknowledged like others, one at a time. Sizes are bytes of UDP payload, times
/// ns.
class MtuSearch {
 public:
  static constexpr std::size_t kMin = 548;    ///< goes everywhere: an IPv4 MTU of 576
  static constexpr std::size_t kBase = 1200;  ///< to begin with, as in QUIC
  static constexpr std::size_t kFine = 16;    ///< how exactly it is found
  static constexpr int kTries = 3;            ///< MAX_PROBES: lost so often, a size is too long
  static constexpr std::int64_t kRaise = 600'000'000'000;  ///< PMTU_RAISE_TIMER: another search
  /// Packets lost in a row, none as long having come since: their size is asked about. A bottleneck
  /// loses four of five as well (tests/net/connection_test.cpp).
  static constexpr std::size_t kDoubt = 6;

  /// @param most  >= kMin
  explicit MtuSearch(std::size_t most) : most_(most) { begin(std::min(kBase, most), most); }

  /// The longest datagram that is sent.
  std::size_t size() const { return size_; }

  /// Bytes of the probe that is due; 0: none.
  std::size_t due(std::int64_t now) {
    if (flying_ != 0) return 0;
    if (is_in_doubt()) return size_;
    if (now < due_at_) return 0;
    if (next_ <= size_) begin(size_, most_);
    return next_ > size_ ? next_ : 0;
  }
  std::int64_t next_due() const {
    if (flying_ != 0) return INT64_MAX;
    if (is_in_doubt()) return INT64_MIN;
    return size_ < most_ ? due_at_ : INT64_MAX;
  }
  void sent(std::size_t bytes, double kbit_per_s, std::int64_t now) {
    flying_ = bytes;
    heard_ = false;
    if (!is_in_doubt()) {
      due_at_ = now + static_cast<std::int64_t>(static_cast<double>(bytes) * kSpacing / kbit_per_s);
    }
  }

  /// Something has come from the other end: the way is there.
  void heard() { heard_ = true; }
  /// Not of probes.
  void lost(std::size_t bytes) {
    // Longer ones than are sent now are known to be lost.
    if (bytes > kMin && bytes <= size_ && !is_in_doubt()) lost_[lost_count_++] = bytes;
  }
  void probe_lost(std::int64_t now) {
    if (std::exchange(flying_, 0) == 0 || !heard_) return;
    if (++tries_ < kTries) return;
    if (!is_in_doubt()) return narrow(next_ - 1, now);
    // A black hole (RFC 8899, Sec. 4.3). All begins below.
    lost_count_ = 0;
    begin(kMin, most_);
    next_ = std::min(kBase, most_);
    due_at_ = now;
  }
  /// Also of probes; after the losses that the same acknowledgement shows.
  void acked(std::size_t bytes, bool is_probe, std::int64_t now) {
    // What is no longer than this was not lost for its length.
    const auto end = lost_.begin() + static_cast<std::ptrdiff_t>(lost_count_);
    const bool doubted = is_in_doubt();
    lost_count_ = static_cast<std::size_t>(
        std::remove_if(lost_.begin(), end, [bytes](std::size_t each) { return each <= bytes; }) -
        lost_.begin());
    if (doubted && !is_in_doubt()) tries_ = 0;
    if (is_probe) flying_ = 0;
    if (bytes <= size_) return;
    size_ = bytes;
    narrow(std::max(end_, bytes), now);
  }

 private:
  static constexpr double kSpacing = 10.0 * 8e6;  // ns, for each byte at 1 kbit/s

  bool is_in_doubt() const { return lost_count_ == lost_.size(); }
  void begin(std::size_t size, std::size_t end) {
    size_ = size;
    end_ = next_ = end;
    tries_ = 0;
  }
  /// Longer ones than `end` do not fit.
  void narrow(std::size_t end, std::int64_t now) {
    end_ = end;
    tries_ = 0;
    if (end_ == most_) {
      next_ = most_;  // the longest first: on most ways it is good
    } else {
      next_ = end_ - size_ < kFine ? size_ : size_ + (end_ - size_ + 1) / 2;
    }
    if (next_ <= size_) due_at_ = now + kRaise;
  }

  std::size_t most_;
  std::size_t size_ = 0;
  std::size_t end_ = 0;   // longer ones do not fit
  std::size_t next_ = 0;  // to be tried; no longer than size_: nothing
  int tries_ = 0;
  std::size_t flying_ = 0;  // bytes of the probe that is on its way; 0: none
  bool heard_ = false;      // since it was sent
  std::int64_t due_at_ = INT64_MIN;
  std::array<std::size_t, kDoubt>
      lost_{};  // lengths, of those as long as which none has come since
  std::size_t lost_count_ = 0;
};

}  // namespace tandem::net
