// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tandem::net {

// What a protected packet holds, little-endian:
//   u32 ack, u64 ack bits, u16 ack delay, then sections
//   u8 1, u16 length, bytes                                a state
//   u8 2, u32 number, u8 flags, u16 length, bytes          a piece of a reliable message
//   u8 3, u16 length, text                                 goodbye

constexpr std::size_t kChannelHeader = 4 + 8 + 2;
constexpr std::size_t kStateHeader = 1 + 2;
constexpr std::size_t kPieceHeader = 1 + 4 + 1 + 2;
constexpr std::size_t kMaxPieceBytes = 480;     // fits into a datagram of 548 bytes
constexpr std::int64_t kAckDelayUnit = 64'000;  // ns

struct ChannelHeader {
  std::uint32_t ack = 0;        // low half of the highest sequence number had; 0: none yet
  std::uint64_t ack_bits = 0;   // bit i: ack - 1 - i
  std::uint16_t ack_delay = 0;  // since `ack` came, in kAckDelayUnit; the largest number: or more
};

struct ChannelSection {
  enum class Kind : std::uint8_t { State = 1, Piece = 2, Goodbye = 3 };
  Kind kind{};
  std::uint32_t number = 0;  // of a piece
  bool last = false;         // piece of its message
  std::span<const std::byte> bytes;
};

struct ChannelPacket {
  ChannelHeader header;
  std::vector<ChannelSection> sections;  // views into what was decoded
};

void encode(const ChannelHeader& header, std::vector<std::byte>& out);
void encode(const ChannelSection& section, std::vector<std::byte>& out);

/// Replaces `packet`, whose memory is used again. False where `plain` is not of this form: nothing
/// of it counts then.
[[nodiscard]] bool decode_channel_packet(std::span<const std::byte> plain, ChannelPacket& packet);

}  // namespace tandem::net
