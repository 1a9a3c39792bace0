// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem::room {

/// Messages between a room's server and its members over their WebSocket: binary, little-endian,
/// kind first (tools/room/README.md).
enum class Wire : std::uint8_t {
  // From a member:
  Join = 1,  ///< u64 its id; comes first
  // Both ways, sealed: u64 receiver (0: all others), from the server u64 sender
  Newest = 2,    ///< may be dropped for a slow member
  Reliable = 3,  ///< never
  Time = 4,      ///< f64 member's time; the answer has it and i64 the server's, ns since 1970
  // From the server:
  Welcome = 5,  ///< u64 ids of all others
  Came = 6,     ///< u64
  Gone = 7,     ///< u64
};

constexpr std::size_t kWireHeader = 9;            ///< kind and id
constexpr std::size_t kMaxWireBytes = 64 * 1024;  ///< of a message

inline void append_u64(std::vector<std::uint8_t>& out, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// @pre 8 bytes from `at` on
inline std::uint64_t read_u64(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    value |= static_cast<std::uint64_t>(bytes[at + i]) << (8 * i);
  }
  return value;
}

inline std::vector<std::uint8_t> message(Wire kind, std::uint64_t id) {
  std::vector<std::uint8_t> out{static_cast<std::uint8_t>(kind)};
  append_u64(out, id);
  return out;
}

}  // namespace tandem::room
