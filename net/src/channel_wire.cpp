// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "channel_wire.h"

#include <algorithm>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

namespace {

constexpr std::uint8_t kLastPiece = 1;

}  // namespace

void encode(const ChannelHeader& header, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u32(header.ack);
  writer.u64(header.ack_bits);
  writer.u16(header.ack_delay);
}

void encode(const ChannelSection& section, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u8(static_cast<std::uint8_t>(section.kind));
  if (section.kind == ChannelSection::Kind::Known) {
    writer.u64(section.known.peer);
    writer.bytes(as_bytes(section.known.address.ip));
    writer.u16(section.known.address.port);
    return;
  }
  if (section.kind == ChannelSection::Kind::Clock) {
    writer.i64(section.clock.sent);
    writer.u32(section.clock_delay);
    writer.i64(section.clock.correction);
    writer.u32(static_cast<std::uint32_t>(section.clock.rate));
    writer.u32(section.clock.bound);
    writer.u8(section.clock.rank);
    return;
  }
  if (section.is_path()) {
    writer.u64(section.token);
    return;
  }
  if (section.kind == ChannelSection::Kind::Piece) {
    writer.u32(section.number);
    writer.u8(static_cast<std::uint8_t>(section.stream << 1 | (section.last ? kLastPiece : 0)));
  }
  writer.u16(static_cast<std::uint16_t>(section.bytes.size()));
  writer.bytes(section.bytes);
}

bool decode_channel_packet(std::span<const std::byte> plain, ChannelPacket& packet) {
  pbd::ByteReader reader(plain);
  packet.sections.clear();
  packet.header.ack = reader.u32();
  packet.header.ack_bits = reader.u64();
  packet.header.ack_delay = reader.u16();
  while (reader.remaining() > 0 && !reader.failed()) {
    ChannelSection section;
    const std::uint8_t kind = reader.u8();
    if (kind < 1 || kind > 8) return false;
    section.kind = static_cast<ChannelSection::Kind>(kind);
    if (section.kind == ChannelSection::Kind::Known) {
      section.known.peer = reader.u64();
      const auto ip = octets(reader.bytes(section.known.address.ip.size()));
      section.known.address.port = reader.u16();
      if (reader.failed()) return false;
      std::ranges::copy(ip, section.known.address.ip.begin());
      packet.sections.push_back(section);
      continue;
    }
    if (section.kind == ChannelSection::Kind::Clock) {
      section.clock.sent = reader.i64();
      section.clock_delay = reader.u32();
      section.clock.correction = reader.i64();
      section.clock.rate = static_cast<std::int32_t>(reader.u32());
      section.clock.bound = reader.u32();
      section.clock.rank = reader.u8();
      if (section.clock.rank > ClockSync::Settled) return false;
      packet.sections.push_back(section);
      continue;
    }
    if (section.is_path()) {
      section.token = reader.u64();
      packet.sections.push_back(section);
      continue;
    }
    if (section.kind == ChannelSection::Kind::Piece) {
      section.number = reader.u32();
      const std::uint8_t flags = reader.u8();
      section.last = (flags & kLastPiece) != 0;
      section.stream = flags >> 1;
    }
    section.bytes = reader.bytes(reader.u16());
    if (section.kind == ChannelSection::Kind::Piece && section.bytes.size() > kMaxPieceBytes) {
      return false;
    }
    packet.sections.push_back(section);
  }
  return !reader.failed();
}

}  // namespace tandem::net
