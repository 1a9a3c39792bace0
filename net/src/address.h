// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>

#include "tandem/consensus/transport.h"

namespace tandem::net {

/// Source or destination of a datagram.
struct Address {
  std::array<std::uint8_t, 16> ip{};  // IPv6, or IPv4 mapped into it
  std::uint16_t port = 0;

  friend auto operator<=>(const Address&, const Address&) = default;
};

constexpr std::array<std::uint8_t, 12> kMappedPrefix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

inline bool is_v4(const Address& address) {
  return std::equal(kMappedPrefix.begin(), kMappedPrefix.end(), address.ip.begin());
}

/// Stands for a peer behind a relay: 100::/64, which is discard-only (RFC 6666), the id, and port
/// 0, from which no datagram is accepted.
inline Address relayed_address(consensus::PeerId peer) {
  Address out;
  out.ip[0] = 1;
  for (std::size_t i = 0; i < 8; ++i) {
    out.ip[8 + i] = static_cast<std::uint8_t>(peer >> (8 * (7 - i)));
  }
  return out;
}
inline bool is_relayed(const Address& address) { return address.port == 0 && address.ip[7] == 0; }
inline consensus::PeerId relayed_peer(const Address& address) {
  consensus::PeerId out = 0;
  for (std::size_t i = 8; i < 16; ++i) out = out << 8 | address.ip[i];
  return out;
}

/// Stands for a DatagramPath by its number: 100:0:0:1::/64, also reserved (RFC 9780).
inline Address path_address(std::uint64_t number) {
  Address out = relayed_address(number);
  out.ip[7] = 1;
  return out;
}
inline bool is_path(const Address& address) { return address.port == 0 && address.ip[7] == 1; }
inline std::uint64_t path_number(const Address& address) { return relayed_peer(address); }

/// Network of one customer of a provider: the first 24 bits of IPv4, the first 48 of IPv6. For an
/// address that stands for one peer, that peer.
inline Address network_of(const Address& address) {
  Address out{.ip = address.ip};
  if (is_relayed(address) || is_path(address)) return out;
  std::fill(out.ip.begin() + (is_v4(address) ? 15 : 6), out.ip.end(), std::uint8_t{0});
  return out;
}

/// Whether it looks like a host's: not multicast, not "any", with a port.
inline bool is_host(const Address& address) {
  if (address.port == 0) return false;
  if (is_v4(address)) return address.ip[12] != 0 && address.ip[12] < 224;
  return address.ip[0] != 0xff && address.ip != std::array<std::uint8_t, 16>{};
}

}  // namespace tandem::net
