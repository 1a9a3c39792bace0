// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "address.h"
#include "crypto.h"
#include "tandem/consensus/transport.h"
#include "tandem/pbd/random.h"

namespace protocol {

using Bytes = std::vector<std::byte>;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMs;

using Dice = tandem::pbd::SplitMix64;

/// Random bytes that can be had again, for tests alone.
inline tandem::net::crypto::Random seeded(std::uint64_t seed) {
  return [dice = std::make_shared<Dice>(seed)](std::span<std::uint8_t> out) {
    for (std::uint8_t& byte : out) byte = static_cast<std::uint8_t>(dice->next());
  };
}

inline tandem::net::crypto::Secret secret(std::uint64_t seed) {
  tandem::net::crypto::Secret out;
  seeded(seed)(out.bytes());
  return out;
}

inline Bytes text(const char* characters) {
  Bytes out;
  for (; *characters != 0; ++characters) out.push_back(static_cast<std::byte>(*characters));
  return out;
}

inline Bytes random_bytes(Dice& dice, std::size_t count) {
  Bytes out(count);
  for (std::byte& byte : out) byte = static_cast<std::byte>(dice.next());
  return out;
}

inline Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

inline std::vector<std::uint8_t> unhex(const char* digits) {
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::vector<std::uint8_t> out;
  for (; digits[0] != 0; digits += 2) {
    out.push_back(static_cast<std::uint8_t>(16 * value(digits[0]) + value(digits[1])));
  }
  return out;
}

/// Address of a peer in tests.
inline tandem::net::Address address_of(tandem::consensus::PeerId peer) {
  return {
      .ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 10, 0, 0, static_cast<std::uint8_t>(peer)},
      .port = 4000};
}

}  // namespace protocol
