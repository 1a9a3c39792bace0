// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "address.h"
#include "clock_sync.h"

namespace tandem::net {

// Contents of a protected packet, little-endian: a header and sections; docs/protocol.md ("Inside")
// has the tables.

constexpr std::size_t kChannelHeader = 4 + 8 + 2;
constexpr std::size_t kStateHeader = 1 + 2;
constexpr std::size_t kPieceHeader = 1 + 4 + 1 + 2;
constexpr std::size_t kClockBytes = 1 + 8 + 4 + 8 + 4 + 4 + 1;
constexpr std::size_t kKnownBytes = 1 + 8 + 16 + 2;
constexpr std::size_t kPathBytes = 1 + 8;
constexpr std::size_t kPaddingHeader = 1 + 2;
constexpr std::uint64_t kNoToken = 0;  // the answer is not awaited
constexpr std::uint32_t kNoClockDelay = UINT32_MAX;
constexpr std::uint8_t kStreams = 128;
constexpr std::size_t kMaxPieceBytes = 480;     // fits into a datagram of 548 bytes
constexpr std::int64_t kAckDelayUnit = 64'000;  // ns

/// A third peer, at the address of the sender's connection to it.
struct KnownPeer {
  consensus::PeerId peer = 0;
  Address address;
};

struct ChannelHeader {
  std::uint32_t ack = 0;        // low half of the highest sequence number received; 0: none yet
  std::uint64_t ack_bits = 0;   // bit i: ack - 1 - i
  std::uint16_t ack_delay = 0;  // since `ack` came, in kAckDelayUnit, saturated
};

struct ChannelSection {
  enum class Kind : std::uint8_t {
    State = 1,
    Piece = 2,
    Goodbye = 3,
    Clock = 4,
    Known = 5,
    Challenge = 6,
    Answer = 7,
    Padding = 8
  };
  bool is_path() const { return kind == Kind::Challenge || kind == Kind::Answer; }

  Kind kind{};
  std::uint32_t number = 0;  // of a piece
  bool last = false;         // whether it is the last piece of its message
  std::uint8_t stream = 0;   // of a piece, below kStreams
  std::span<const std::byte> bytes;
  std::uint64_t token = 0;  // of a challenge or its answer
  KnownPeer known;
  ClockClaim clock;
  /// Time from receiving the packet that the header acknowledges to sending this one, ns, by the
  /// sender's clock; kNoClockDelay: none received, or too long ago.
  std::uint32_t clock_delay = kNoClockDelay;
};

struct ChannelPacket {
  ChannelHeader header;
  std::vector<ChannelSection> sections;  // views into the decoded bytes
};

void encode(const ChannelHeader& header, std::vector<std::byte>& out);
void encode(const ChannelSection& section, std::vector<std::byte>& out);

/// Replaces `packet`, whose memory is reused. False if `plain` is malformed: nothing of it counts
/// then.
[[nodiscard]] bool decode_channel_packet(std::span<const std::byte> plain, ChannelPacket& packet);

}  // namespace tandem::net
