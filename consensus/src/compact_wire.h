// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/consensus/compact.h"
#include "tandem/pbd/bytes.h"

// What the two parts of the codec, update.cpp and compact.cpp, share.
namespace tandem::consensus {

enum class MessageKind : std::uint8_t {
  States = 1,
  Springs = 2,
  Leave = 3,
  Ownership = 4,
  CompactStates = 5,
  Names = 6,
  NamesWanted = 7,
  Alive = 8,
  Anchors = 9
};

inline constexpr std::size_t kNamesWantedBytes = 4;
inline constexpr std::size_t kAliveBytes = 8;

/// Magic, version, kind, count.
void write_header(std::vector<std::byte>& out, MessageKind kind, std::size_t count);
/// Overwrite two bytes.
void put_u16(std::vector<std::byte>& out, std::size_t at, std::size_t value);
/// check() of an anchor as a spring has it.
CodecResult check_anchor(const AnchorUpdate& anchor);
/// check() without the id.
CodecResult check_state(const StateUpdate& update);

/// What follows the header of a message of `count` records; appended.
CodecResult decode_compact(pbd::ByteReader& in, std::size_t count, std::vector<CompactState>& out);
CodecResult decode_anchors(pbd::ByteReader& in, std::size_t count, std::vector<AnchorUpdate>& out);
CodecResult decode_names(pbd::ByteReader& in, std::size_t count, std::vector<NameUpdate>& out);

}  // namespace tandem::consensus
