// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "channel_wire.h"
#include "rtt.h"

namespace tandem::net {

/// Unacknowledged packets: which were received or lost, and their round trips. A packet is lost
/// when three later ones were received, or after a timeout; it may still turn out to be received.
/// Bounded: a ring as large as the most packets ever awaited at once, so that a quiet connection's
/// stays in the cache.
class SentPackets {
 public:
  static constexpr std::size_t kRing = 1024;     // largest
  static constexpr std::size_t kFirstRing = 64;  // initial; one acknowledgement covers as many
  static constexpr std::size_t kMaxPieces = 8;   // of one packet
  static constexpr std::uint64_t kReorder = 3;

  /// A packet to be acknowledged. @param bytes  on the wire
  /// @param pieces  numbers, at most kMaxPieces
  void sent(std::uint64_t sequence, std::size_t bytes, std::span<const std::uint64_t> pieces,
            std::int64_t now);
  /// An empty packet, whose fate does not matter.
  void sent_empty(std::uint64_t sequence, std::int64_t now);
  /// A padded packet: its loss tells about its length, not about the rate.
  void sent_probe(std::uint64_t sequence, std::size_t bytes, std::int64_t now);
  /// When the packet acknowledged by `header` was sent, if known.
  std::optional<std::int64_t> sent_at(const ChannelHeader& header) const;

  struct Outcome {
    std::vector<std::uint64_t> acked_pieces;
    std::vector<std::uint64_t> lost_pieces;
    /// Bytes on the wire, of each packet.
    struct Size {
      std::size_t bytes = 0;
      bool is_probe = false;
    };
    std::vector<Size> acked_sizes;
    std::vector<Size> lost_sizes;
    std::uint64_t acked_packets = 0;
    std::uint64_t acked_bytes = 0;
    std::uint64_t lost_packets = 0;
    std::uint64_t late_packets = 0;  // counted as lost before

    void clear();
  };
  /// False if it acknowledges a packet that was never sent. Adds to `outcome`.
  [[nodiscard]] bool on_ack(const ChannelHeader& header, std::int64_t now, Outcome& outcome);
  /// Packets that waited too long are lost. Adds to `outcome`.
  void on_time(std::int64_t now, Outcome& outcome);

  /// A new path: earlier round trips do not apply to it.
  void begin_path() {
    rtt_ = {};
    path_first_ = latest_sent_ + 1;
    backoff_ = 0;
  }

  std::uint64_t highest_acknowledged() const { return highest_acked_; }
  /// When the first packet with this or a later number was sent, or the first one still known;
  /// INT64_MAX: none.
  std::int64_t first_sent_from(std::uint64_t sequence) const;
  const RttEstimate& rtt() const { return rtt_; }
  std::size_t in_flight() const { return in_flight_; }

 private:
  enum class State : std::uint8_t { None, Flying, Acked, Lost };
  struct Entry {
    std::uint64_t sequence = 0;
    std::int64_t at = 0;
    std::size_t bytes = 0;
    State state = State::None;
    bool is_probe = false;
    std::uint8_t piece_count = 0;
    std::array<std::uint64_t, kMaxPieces> pieces{};
  };

  // The ring's size is a power of two.
  Entry& slot(std::uint64_t sequence) { return entries_[sequence & (entries_.size() - 1)]; }
  const Entry& slot(std::uint64_t sequence) const {
    return entries_[sequence & (entries_.size() - 1)];
  }
  void grow();
  std::uint64_t widen(std::uint32_t ack) const;
  /// Whether it may still be acknowledged: packets counted as lost are late on long round trips.
  static bool may_come(const Entry& entry, std::int64_t now);
  Entry& next_slot(std::uint64_t sequence, std::int64_t now);
  void acked(std::uint64_t sequence, Outcome& outcome);
  void lost(Entry& entry, Outcome& outcome);

  std::vector<Entry> entries_ = std::vector<Entry>(kFirstRing);
  std::uint64_t latest_sent_ = 0;
  std::uint64_t highest_acked_ = 0;
  std::uint64_t known_acked_ = 0;  // bit i: the packet 1 + i before that one
  std::uint64_t oldest_ = 1;       // no older one is in flight
  std::uint64_t path_first_ = 0;   // first packet on the present path
  std::size_t in_flight_ = 0;
  int backoff_ = 0;  // successive timeouts without an acknowledgement
  std::int64_t last_timeout_ = 0;
  Outcome overrun_;  // overwritten in the ring before they were settled
  RttEstimate rtt_;
};

}  // namespace tandem::net
