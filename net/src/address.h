// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <compare>
#include <cstdint>

namespace tandem::net {

/// Where a datagram came from or goes to.
struct Address {
  std::array<std::uint8_t, 16> ip{};  // IPv6, or IPv4 mapped into it
  std::uint16_t port = 0;

  friend auto operator<=>(const Address&, const Address&) = default;
};

}  // namespace tandem::net
