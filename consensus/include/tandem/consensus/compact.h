// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/consensus/update.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

// States in few bits, docs/protocol.md: the sender names each body by an index, and numbers are
// rounded. A moving body takes about 27 bytes and a resting one 14, headers in full packets
// included; a StateUpdate takes 93.

/// m, of positions: represented exactly by 64-bit floats up to kMaxPosition.
inline constexpr double kPositionQuantum = 1.0 / 4096.0;
/// m: positions are relative to the middle of a cube of this edge.
inline constexpr double kCellEdge = 64.0;
/// 15 bits for each of the three smallest components of a quaternion; the largest follows from
/// them.
inline constexpr double kOrientationQuantum = 0.70710678118654752 / 16383.0;
inline constexpr double kLinearSpeedQuantum = 1.0 / 1024.0;   ///< m/s, up to 64; else floats
inline constexpr double kAngularSpeedQuantum = 1.0 / 1024.0;  ///< rad/s, up to 32; else floats
inline constexpr double kInfluenceQuantum = 1.0 / 65535.0;
inline constexpr double kAnchorQuantum = 1.0 / 65536.0;     ///< m, up to 2^15
inline constexpr double kAnchorSpeedQuantum = 1.0 / 256.0;  ///< m/s, up to 2^7

/// A state, and the sender's index of its body.
struct TANDEM_API IndexedState {
  std::uint16_t index = 0;
  StateUpdate update = {};  ///< its id is ignored
};

/// Append one message with as many of these states as fit into a packet of `max_bytes`, at most
/// kMaxRecords; none if not even one fits. States that check() refuses are left out. The others are
/// changed to what the receiver decodes: rounded to the quanta, StateUpdate::rounded set, without
/// velocities if flags.resting is set.
/// @param states  by ascending index, each once; all have the stamp of the first
/// @return how many of `states` were written or left out
TANDEM_API std::size_t encode_compact(std::span<IndexedState> states, std::uint32_t table,
                                      std::size_t max_bytes, std::vector<std::byte>& out);

/// Append one message with the anchors of as many of these springs as fit into a packet of
/// `max_bytes`, at most kMaxRecords; none if not even one fits. Springs that the format cannot hold
/// are appended to `others`, to be sent in full.
/// @return how many of `springs` were written or appended to `others`
TANDEM_API std::size_t encode_anchors(std::span<const SpringUpdate> springs, std::size_t max_bytes,
                                      std::vector<SpringUpdate>& others,
                                      std::vector<std::byte>& out);

inline constexpr std::size_t kIndicesHeaderBytes = kHeaderBytes + 4 + 2;  ///< table, first index
inline constexpr std::size_t kIdBytes = 16;
/// Ids that fit into a message of `bytes` bytes.
constexpr std::size_t indices_in(std::size_t bytes) {
  return bytes < kIndicesHeaderBytes ? 0 : (bytes - kIndicesHeaderBytes) / kIdBytes;
}
/// Append a message that assigns consecutive indices to ids. @pre 1 to kMaxRecords ids, none zero;
/// first + ids.size() <= 65536
TANDEM_API void encode_indices(std::uint32_t table, std::uint16_t first,
                               std::span<const SharedId> ids, std::vector<std::byte>& out);
TANDEM_API void encode(const IndicesWanted& wanted, std::vector<std::byte>& out);
TANDEM_API void encode(const Alive& alive, std::vector<std::byte>& out);

}  // namespace tandem::consensus
