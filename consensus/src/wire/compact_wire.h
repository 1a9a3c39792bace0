// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/consensus/compact.h"
#include "tandem/pbd/bytes.h"

// Shared parts of the codec: update*.cpp and compact*.cpp.
namespace tandem::consensus {

enum class MessageKind : std::uint8_t {
  States = 1,
  Springs = 2,
  Leave = 3,
  Ownership = 4,
  CompactStates = 5,
  Indices = 6,
  IndicesWanted = 7,
  Alive = 8,
  Anchors = 9,
  Acts = 10,
  ActReceipts = 11
};

inline constexpr std::size_t kIndicesWantedBytes = 4;
inline constexpr std::size_t kAliveBytes = 8;

/// For the components of a full orientation: fixed-point numbers of 32 bits.
inline constexpr double kQuatScale = 1073741824.0;  // 2^30
/// @pre |component| < 2
inline std::int32_t to_fixed(double component) {
  return static_cast<std::int32_t>(std::lround(component * kQuatScale));
}
inline double from_fixed(std::int32_t value) { return value / kQuatScale; }

inline constexpr std::size_t kFlags = 6;
/// All flags, by bit. Four of them are also in compact states, in this order.
inline auto by_bit(auto& flags) {
  return std::array<decltype(&flags.held), kFlags>{&flags.in_contact,   &flags.held,
                                                   &flags.owner_driven, &flags.teleported,
                                                   &flags.leads,        &flags.resting};
}
inline std::uint8_t pack(const UpdateFlags& flags) {
  unsigned bits = 0, bit = 0;
  for (const bool* flag : by_bit(flags)) bits |= (*flag ? 1U : 0U) << bit++;
  return static_cast<std::uint8_t>(bits);
}
inline UpdateFlags unpack(std::uint64_t bits) {
  UpdateFlags flags;
  unsigned bit = 0;
  for (bool* flag : by_bit(flags)) *flag = (bits >> bit++ & 1) != 0;
  return flags;
}

inline void write_id(pbd::ByteWriter& out, const SharedId& id) {
  out.u64(id.high);
  out.u64(id.low);
}
inline SharedId read_id(pbd::ByteReader& in) {
  const std::uint64_t high = in.u64();
  return {high, in.u64()};
}

inline CodecResult fault(PacketFault kind, const char* detail) { return {kind, detail, 0}; }

/// Writes magic, version, kind and count.
void write_header(std::vector<std::byte>& out, MessageKind kind, std::size_t count);
/// Overwrites two bytes.
void put_u16(std::vector<std::byte>& out, std::size_t at, std::size_t value);
/// check() of an anchor, with a spring's bounds.
CodecResult check_anchor(const AnchorUpdate& anchor);
/// check() without the id.
CodecResult check_state(const StateUpdate& update);

/// Decode what follows the header of a message of `count` records; appended.
CodecResult decode_compact(pbd::ByteReader& in, std::size_t count, std::vector<CompactState>& out);
CodecResult decode_anchors(pbd::ByteReader& in, std::size_t count, std::vector<AnchorUpdate>& out);
CodecResult decode_indices(pbd::ByteReader& in, std::size_t count,
                           std::vector<IndexAssignment>& out);

}  // namespace tandem::consensus
