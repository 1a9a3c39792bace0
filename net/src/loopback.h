// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <asio/ip/address.hpp>
#include <cstdint>
#include <string>
#include <system_error>

namespace tandem::net {

/// Converts IPv4 addresses seen through an IPv6 socket to plain ones, so that a peer has one
/// spelling.
inline asio::ip::address plain(const asio::ip::address& address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return address;
}

/// IPv6, or IPv4 mapped into it.
inline std::array<std::uint8_t, 16> to_bytes(const asio::ip::address& address) {
  const asio::ip::address ip = plain(address);
  return ip.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, ip.to_v4()).to_bytes()
                    : ip.to_v6().to_bytes();
}

inline bool is_loopback(const asio::ip::address& address) { return plain(address).is_loopback(); }

/// For a numeric address, or "localhost".
inline bool is_loopback(const std::string& host) {
  if (host == "localhost") return true;
  std::error_code error;
  const asio::ip::address address = asio::ip::make_address(host, error);
  return !error && is_loopback(address);
}

}  // namespace tandem::net
