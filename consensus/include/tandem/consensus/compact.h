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

// States in few bits, docs/protocol.md: bodies by an index that the sender has named before,
// numbers rounded. About 27 bytes for a body that moves, 14 for one that rests, headers included in
// full packets, where a StateUpdate in full takes 93.

/// m, of positions: exact in 64-bit floats wherever kMaxPosition lets a body be.
inline constexpr double kPositionQuantum = 1.0 / 4096.0;
/// m: positions are relative to the middle of a cube of this edge.
inline constexpr double kCellEdge = 64.0;
/// Of the three smallest components of a quaternion, 15 bits each; the largest follows from them.
inline constexpr double kOrientationQuantum = 0.70710678118654752 / 16383.0;
inline constexpr double kLinearSpeedQuantum = 1.0 / 1024.0;  ///< m/s, up to 64; above 32-bit floats
inline constexpr double kAngularSpeedQuantum = 1.0 / 1024.0;  ///< rad/s, up to 32; likewise
inline constexpr double kInfluenceQuantum = 1.0 / 65535.0;
inline constexpr double kAnchorQuantum = 1.0 / 65536.0;     ///< m, up to 2^15
inline constexpr double kAnchorSpeedQuantum = 1.0 / 256.0;  ///< m/s, up to 2^7

/// A state and the index that the sender has given to its body.
struct TANDEM_API IndexedState {
  std::uint16_t index = 0;
  StateUpdate update = {};  ///< the id is not looked at
};

/// Append one message with as many of these states as bring the packet to `max_bytes`, and up to
/// kMaxRecords; nothing where not even one fits. States that check() refuses are left out; the
/// others come out as the receiver will have them: rounded to the quanta, StateUpdate::rounded set,
/// without velocities where flags.resting is set.
/// @param states  by ascending index, no index twice; all of the stamp of the first one
/// @return how many of `states` are dealt with
TANDEM_API std::size_t encode_compact(std::span<IndexedState> states, std::uint32_t table,
                                      std::size_t max_bytes, std::vector<std::byte>& out);

/// Append one message with the anchors of as many of these springs as bring the packet to
/// `max_bytes`, and up to kMaxRecords; nothing where not even one fits. Springs that the format
/// cannot hold are appended to `others`: they are to be told in full.
/// @return how many of `springs` are dealt with, one way or the other
TANDEM_API std::size_t encode_anchors(std::span<const SpringUpdate> springs, std::size_t max_bytes,
                                      std::vector<SpringUpdate>& others,
                                      std::vector<std::byte>& out);

inline constexpr std::size_t kIndicesHeaderBytes = kHeaderBytes + 4 + 2;  ///< table, first index
inline constexpr std::size_t kIdBytes = 16;
/// Ids that fit into a message of so many bytes; 0 where none does.
constexpr std::size_t indices_in(std::size_t bytes) {
  return bytes < kIndicesHeaderBytes ? 0 : (bytes - kIndicesHeaderBytes) / kIdBytes;
}
/// Append a message with the names of consecutive indices. @pre 1 to kMaxRecords ids, none zero;
/// first + ids.size() <= 65536
TANDEM_API void encode_indices(std::uint32_t table, std::uint16_t first,
                               std::span<const SharedId> ids, std::vector<std::byte>& out);
TANDEM_API void encode(const IndicesWanted& wanted, std::vector<std::byte>& out);
TANDEM_API void encode(const Alive& alive, std::vector<std::byte>& out);

}  // namespace tandem::consensus
