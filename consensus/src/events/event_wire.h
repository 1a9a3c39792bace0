// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::consensus {

// Packets of an event channel, little-endian:
//   u16 magic, u8 version, u8 kind, i64 epoch, u64 number, then
//   kind 1, an event:   u64 first, i64 stamp, u8 length, topic, payload to the end
//   kind 2, acknowledgement: nothing; `number` is the next expected event
// An epoch is the sender's list for one receiver, named by the session time at which it was begun;
// numbers count its events from 0, `first` is the lowest one still kept.

inline constexpr std::uint16_t kEventMagic = 0x5645;  // "EV" on the wire
inline constexpr std::uint8_t kEventVersion = 1;
inline constexpr std::size_t kEventHeaderBytes = 2 + 1 + 1 + 8 + 8;
inline constexpr std::size_t kEventBytes = kEventHeaderBytes + 8 + 8 + 1;

struct EventMessage {
  enum class Kind : std::uint8_t { Event = 1, Acknowledgement = 2 };
  Kind kind = Kind::Event;
  SessionTime epoch = 0;
  std::uint64_t number = 0;
  // Events only.
  std::uint64_t first = 0;
  SessionTime stamp = 0;
  std::string_view topic;
  std::span<const std::byte> payload;
};

/// Whether a packet belongs to an event channel, readable or not.
bool is_event_packet(std::span<const std::byte> packet);
void encode(const EventMessage& message, std::vector<std::byte>& out);
/// Topic and payload point into the packet. nullopt if it cannot be decoded.
std::optional<EventMessage> decode_event(std::span<const std::byte> packet);

}  // namespace tandem::consensus
