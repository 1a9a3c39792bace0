// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/packet_coding.h"

#include <algorithm>

namespace tandem::demos {

namespace {

/// A shorter run of equal bytes costs more than it saves.
constexpr std::size_t kWorthwhile = 3;

/// Number of equal bytes from `at` on.
std::size_t equal_from(std::span<const std::byte> a, std::span<const std::byte> b, std::size_t at) {
  std::size_t end = at;
  while (end < a.size() && a[end] == b[end]) ++end;
  return end - at;
}

}  // namespace

std::size_t PacketHistory::find(consensus::PeerId from, std::size_t length) const {
  std::size_t i = 0;
  while (i < kSlots && (slots_[i].from != from || slots_[i].packet.size() != length)) ++i;
  return i;
}

std::span<const std::byte> PacketHistory::like(consensus::PeerId from, std::size_t length) const {
  const std::size_t slot = find(from, length);
  if (slot == kSlots) return {};
  return slots_[slot].packet;
}

void PacketHistory::remember(consensus::PeerId from, std::span<const std::byte> packet) {
  std::size_t slot = find(from, packet.size());
  if (slot == kSlots) {
    slot = next_;
    next_ = (next_ + 1) % kSlots;
  }
  slots_[slot].from = from;
  slots_[slot].packet.assign(packet.begin(), packet.end());
}

void code_packet(std::span<const std::byte> packet, std::span<const std::byte> base,
                 std::vector<std::byte>& out) {
  for (std::size_t at = 0; at < packet.size();) {
    const std::size_t same = equal_from(packet, base, at);
    const std::size_t first = at + same;
    std::size_t end = first;
    while (end < packet.size()) {
      const std::size_t next = equal_from(packet, base, end);
      if (next >= kWorthwhile || end + next == packet.size()) break;
      end += std::max<std::size_t>(1, next);
    }
    write_varint(same, out);
    write_varint(end - first, out);
    const std::span<const std::byte> others = packet.subspan(first, end - first);
    out.insert(out.end(), others.begin(), others.end());
    at = end;
  }
}

bool decode_packet(std::span<const std::byte> in, std::size_t& at, std::span<std::byte> packet) {
  for (std::size_t filled = 0; filled < packet.size();) {
    std::uint64_t same = 0;
    std::uint64_t others = 0;
    if (!read_varint(in, at, same) || !read_varint(in, at, others)) return false;
    if (same > packet.size() - filled) return false;
    filled += static_cast<std::size_t>(same);
    if (others > packet.size() - filled || others > in.size() - at) return false;
    // Empty runs would never end.
    if (same == 0 && others == 0) return false;
    std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(at), others,
                packet.begin() + static_cast<std::ptrdiff_t>(filled));
    filled += static_cast<std::size_t>(others);
    at += static_cast<std::size_t>(others);
  }
  return true;
}

bool read_varint(std::span<const std::byte> in, std::size_t& at, std::uint64_t& value) {
  value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (at >= in.size()) return false;
    const auto byte = static_cast<std::uint8_t>(in[at++]);
    if (shift == 63 && byte > 1) return false;
    value |= std::uint64_t{byte & 0x7fu} << shift;
    if (byte < 0x80) return true;
  }
  return false;
}

void write_varint(std::uint64_t value, std::vector<std::byte>& out) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::byte>(value | 0x80));
  out.push_back(static_cast<std::byte>(value));
}

}  // namespace tandem::demos
