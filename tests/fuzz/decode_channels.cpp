// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a member's packets have inside.
#include "channel_wire.h"
#include "target.h"

namespace fuzz {

using namespace tandem::net;
using Kind = ChannelSection::Kind;

void run(std::span<const std::byte> input) {
  ChannelPacket packet;
  if (!decode_channel_packet(input, packet)) return;
  Bytes again;
  encode(packet.header, again);
  for (const ChannelSection& section : packet.sections) {
    require(section.kind != Kind::Piece || section.bytes.size() <= kMaxPieceBytes);
    encode(section, again);
  }
  require(std::ranges::equal(again, input));
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> out;
  const Bytes text(20, std::byte{65});
  const ChannelSection sections[] = {
      {.kind = Kind::State, .bytes = text},
      {.kind = Kind::Piece, .number = 9, .last = true, .stream = 3, .bytes = text},
      {.kind = Kind::Goodbye, .bytes = text},
      {.kind = Kind::Clock,
       .clock = {.sent = 5, .correction = -7, .rate = -100, .bound = 12, .rank = 2},
       .clock_delay = 1000},
      {.kind = Kind::Known, .known = {.peer = 4, .address = {.ip = {1, 2, 3}, .port = 99}}},
      {.kind = Kind::Challenge, .token = 5},
      {.kind = Kind::Answer, .token = 5},
      {.kind = Kind::Padding, .bytes = text}};
  Bytes all;
  encode(ChannelHeader{.ack = 4, .ack_bits = 7, .ack_delay = 3}, all);
  for (const ChannelSection& section : sections) {
    encode(ChannelHeader{.ack = 1}, out.emplace_back());
    encode(section, out.back());
    encode(section, all);
  }
  out.push_back(all);
  return out;
}

}  // namespace fuzz
