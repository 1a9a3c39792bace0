// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// The last packets of a trace, by sender and length. A peer's packet of states names the same
/// bodies as its last one, and most of them have not moved: what differs is little. Bounded, and no
/// allocation once its buffers have grown.
class PacketHistory {
 public:
  /// The last one of this sender that was as long; empty where none is known.
  std::span<const std::byte> like(consensus::PeerId from, std::size_t length) const;
  void remember(consensus::PeerId from, std::span<const std::byte> packet);

 private:
  static constexpr std::size_t kSlots = 64;
  struct Slot {
    consensus::PeerId from = 0;
    std::vector<std::byte> packet;
  };
  std::size_t find(consensus::PeerId from, std::size_t length) const;

  std::array<Slot, kSlots> slots_;
  std::size_t next_ = 0;  ///< to be replaced
};

/// Appends how `packet` differs from `base`, which is as long: runs of equal bytes and of others.
void code_packet(std::span<const std::byte> packet, std::span<const std::byte> base,
                 std::vector<std::byte>& out);
/// The way back. Reads from `at` on and moves it. @param packet  in: the base; out: the packet
/// @return false where the bytes say something else than a packet of this length; any is in it then
bool decode_packet(std::span<const std::byte> in, std::size_t& at, std::span<std::byte> packet);

/// A varint of up to 64 bits at `at`, which it moves; false where it is longer or the bytes end.
bool read_varint(std::span<const std::byte> in, std::size_t& at, std::uint64_t& value);
void write_varint(std::uint64_t value, std::vector<std::byte>& out);

}  // namespace tandem::demos
