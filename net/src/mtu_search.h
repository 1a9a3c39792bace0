// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace tandem::net {

/// Path MTU discovery: RFC 8899 (DPLPMTUD), docs/protocol.md. Probes are padded packets,
/// acknowledged like others, one at a time. Sizes are bytes of UDP payload, times ns.
class MtuSearch {
 public:
  static constexpr std::size_t kMin = 548;    ///< works everywhere: an IPv4 MTU of 576
  static constexpr std::size_t kBase = 1200;  ///< initially, as in QUIC
  static constexpr std::size_t kFine = 16;    ///< precision of the result
  static constexpr int kTries = 3;            ///< MAX_PROBES: losses after which a size is too long
  static constexpr std::int64_t kRaise = 600'000'000'000;  ///< PMTU_RAISE_TIMER: next search
  /// Packets lost in a row, with none of their length received since, that put the size in doubt. A
  /// bottleneck too loses four of five (tests/net/connection_test.cpp).
  static constexpr std::size_t kDoubt = 6;

  /// @param most  >= kMin
  explicit MtuSearch(std::size_t most) : most_(most) { begin(std::min(kBase, most), most); }

  /// The longest datagram to send.
  std::size_t size() const { return size_; }

  /// Bytes of the due probe; 0: none.
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

  /// The other end was heard: the path works.
  void heard() { heard_ = true; }
  /// For packets other than probes.
  void lost(std::size_t bytes) {
    // Longer ones than the present size are known to be lost.
    if (bytes > kMin && bytes <= size_ && !is_in_doubt()) lost_[lost_count_++] = bytes;
  }
  void probe_lost(std::int64_t now) {
    if (std::exchange(flying_, 0) == 0 || !heard_) return;
    if (++tries_ < kTries) return;
    if (!is_in_doubt()) return narrow(next_ - 1, now);
    // A black hole (RFC 8899, Sec. 4.3). Start again from below.
    lost_count_ = 0;
    begin(kMin, most_);
    next_ = std::min(kBase, most_);
    due_at_ = now;
  }
  /// Probes included; call after the losses of the same acknowledgement.
  void acked(std::size_t bytes, bool is_probe, std::int64_t now) {
    // Packets no longer than this were not lost for their length.
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
  static constexpr double kSpacing = 10.0 * 8e6;  // ns per byte at 1 kbit/s

  bool is_in_doubt() const { return lost_count_ == lost_.size(); }
  void begin(std::size_t size, std::size_t end) {
    size_ = size;
    end_ = next_ = end;
    tries_ = 0;
  }
  /// Set the longest size that may fit.
  void narrow(std::size_t end, std::int64_t now) {
    end_ = end;
    tries_ = 0;
    if (end_ == most_) {
      next_ = most_;  // the longest first: most paths carry it
    } else {
      next_ = end_ - size_ < kFine ? size_ : size_ + (end_ - size_ + 1) / 2;
    }
    if (next_ <= size_) due_at_ = now + kRaise;
  }

  std::size_t most_;
  std::size_t size_ = 0;
  std::size_t end_ = 0;   // longer ones do not fit
  std::size_t next_ = 0;  // next size to probe; at most size_: none
  int tries_ = 0;
  std::size_t flying_ = 0;  // bytes of the outstanding probe; 0: none
  bool heard_ = false;      // since the probe was sent
  std::int64_t due_at_ = INT64_MIN;
  std::array<std::size_t, kDoubt>
      lost_{};  // lengths of lost packets, with none as long received since
  std::size_t lost_count_ = 0;
};

}  // namespace tandem::net
