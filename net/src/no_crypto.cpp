// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Replaces crypto.cpp in builds without libsodium.
#include <algorithm>
#include <stdexcept>

#include "crypto.h"

namespace tandem::net::crypto {

namespace {

[[noreturn]] void refuse() {
  throw std::runtime_error("keys need a build with libsodium (Debian: libsodium-dev, pkgconf)");
}

}  // namespace

bool is_available() { return false; }
void initialise() { refuse(); }
void wipe(std::span<std::uint8_t> bytes) { std::fill(bytes.begin(), bytes.end(), std::uint8_t{0}); }

// Unreachable: initialise() is called before these.
using Octets = std::span<const std::uint8_t>;
Secret::Secret(std::span<const std::uint8_t, kKeyBytes> /*bytes*/) { refuse(); }
bool operator==(const Secret& /*a*/, const Secret& /*b*/) { refuse(); }
Random system_random() { refuse(); }
KeyPair make_key_pair(const Random& /*random*/) { refuse(); }
PublicKey public_key_of(const Secret& /*secret*/) { refuse(); }
bool agree(const Secret& /*own*/, const PublicKey& /*other*/, Secret& /*out*/) { refuse(); }
PublicKey signing_public_key(const Secret& /*secret*/) { refuse(); }
std::array<std::uint8_t, kSignatureBytes> sign(const Secret& /*secret*/, Octets /*message*/) {
  refuse();
}
bool verify(const PublicKey& /*key*/, Octets /*message*/, Octets /*signature*/) { refuse(); }
Hash hash(Octets /*first*/, Octets /*second*/) { refuse(); }
Hash hmac(Octets /*key*/, Octets /*first*/, Octets /*second*/) { refuse(); }
std::array<std::uint8_t, 16> mac16(const Secret& /*key*/, Octets /*message*/) { refuse(); }
Secret next_key(const Secret& /*key*/) { refuse(); }
void seal(const Secret& /*key*/, std::uint64_t /*counter*/, Octets /*header*/, Octets /*plain*/,
          std::span<std::uint8_t> /*out*/) {
  refuse();
}
bool open(const Secret& /*key*/, std::uint64_t /*counter*/, Octets /*header*/, Octets /*sealed*/,
          std::span<std::uint8_t> /*out*/) {
  refuse();
}

}  // namespace tandem::net::crypto
