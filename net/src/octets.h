// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tandem::net {

/// The same bytes, as the crypto functions take them.
inline std::span<const std::uint8_t> octets(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}
inline std::span<std::uint8_t> octets(std::span<std::byte> bytes) {
  return {reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()};
}
inline std::span<const std::byte> as_bytes(std::span<const std::uint8_t> octets) {
  return std::as_bytes(octets);
}

}  // namespace tandem::net
