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

/// The last packets of a trace, by sender and length. Successive state packets name the same
/// bodies, most of which have not moved, so they differ little. Bounded, and no allocation once its
/// buffers have grown.
class PacketHistory {
 public:
  /// The last one of this sender with this length; empty if there is none.
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
  std::size_t next_ = 0;  ///< next to be replaced
};

/// Appends the difference of `packet` from `base`, of equal length: runs of equal and of other
/// bytes.
void code_packet(std::span<const std::byte> packet, std::span<const std::byte> base,
                 std::vector<std::byte>& out);
/// Decodes from `at` on and moves it. @param packet  in: the base; out: the packet
/// @return false if the bytes do not encode a packet of this length; its content is then undefined
bool decode_packet(std::span<const std::byte> in, std::size_t& at, std::span<std::byte> packet);

/// A varint of up to 64 bits at `at`, which it moves; false if it is longer or the bytes end.
bool read_varint(std::span<const std::byte> in, std::size_t& at, std::uint64_t& value);
void write_varint(std::uint64_t value, std::vector<std::byte>& out);

}  // namespace tandem::demos
