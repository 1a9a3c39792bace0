// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "events/event_wire.h"

#include "tandem/consensus/update.h"
#include "tandem/pbd/bytes.h"

namespace tandem::consensus {

bool is_event_packet(std::span<const std::byte> packet) {
  pbd::ByteReader in(packet);
  return in.u16() == kEventMagic && !in.failed();
}

void encode(const EventMessage& message, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u16(kEventMagic);
  writer.u8(kEventVersion);
  writer.u8(static_cast<std::uint8_t>(message.kind));
  writer.i64(message.epoch);
  writer.u64(message.number);
  if (message.kind != EventMessage::Kind::Event) return;
  writer.u64(message.first);
  writer.i64(message.stamp);
  writer.u8(static_cast<std::uint8_t>(message.topic.size()));
  writer.bytes(std::as_bytes(std::span(message.topic)));
  writer.bytes(message.payload);
}

std::optional<EventMessage> decode_event(std::span<const std::byte> packet) {
  pbd::ByteReader in(packet);
  EventMessage message;
  const bool ours = in.u16() == kEventMagic && in.u8() == kEventVersion;
  message.kind = static_cast<EventMessage::Kind>(in.u8());
  message.epoch = in.i64();
  message.number = in.u64();
  if (!ours || in.failed()) return std::nullopt;
  if (message.kind == EventMessage::Kind::Acknowledgement) {
    return in.remaining() == 0 ? std::optional(message) : std::nullopt;
  }
  if (message.kind != EventMessage::Kind::Event) return std::nullopt;
  message.first = in.u64();
  message.stamp = in.i64();
  const std::size_t length = in.u8();
  const auto topic = in.bytes(length);
  message.payload = in.bytes(in.remaining());
  message.topic = {reinterpret_cast<const char*>(topic.data()), topic.size()};
  const bool in_range = message.first <= message.number && message.number < UINT64_MAX &&
                        message.stamp > -kMaxStamp && message.stamp < kMaxStamp;
  if (in.failed() || !in_range) return std::nullopt;
  return message;
}

}  // namespace tandem::consensus
