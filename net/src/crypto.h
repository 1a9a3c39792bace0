// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace tandem::net::crypto {

// What of libsodium is used. crypto.cpp is the only file that includes it, and no_crypto.cpp stands
// in for that where there is none.

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kTagBytes = 16;
constexpr std::size_t kHashBytes = 64;
constexpr std::size_t kSignatureBytes = 64;

using PublicKey = std::array<std::uint8_t, kKeyBytes>;  // X25519
using Hash = std::array<std::uint8_t, kHashBytes>;      // BLAKE2b-512

/// Whether this build has the library. Without, initialise() throws, and nothing works.
bool is_available();
/// Chooses the fastest code that the processor has. Call it before the rest, as often as you like.
/// Throws std::runtime_error where the library cannot be initialised.
void initialise();

/// Overwrites memory in a way that the compiler keeps.
void wipe(std::span<std::uint8_t> bytes);

/// 32 secret bytes, overwritten when they go.
class Secret {
 public:
  Secret() = default;
  explicit Secret(std::span<const std::uint8_t, kKeyBytes> bytes);
  Secret(const Secret&) = default;
  Secret& operator=(const Secret&) = default;
  ~Secret() { wipe(bytes_); }

  std::span<std::uint8_t, kKeyBytes> bytes() { return bytes_; }
  std::span<const std::uint8_t, kKeyBytes> bytes() const { return bytes_; }
  /// In constant time.
  friend bool operator==(const Secret& a, const Secret& b);

 private:
  std::array<std::uint8_t, kKeyBytes> bytes_{};
};

/// Fills with unpredictable bytes. Tests may give a generator of their own; nothing else may.
using Random = std::function<void(std::span<std::uint8_t>)>;
/// The system's. Initialises.
Random system_random();
std::uint64_t random_number(const Random& random);

struct KeyPair {
  Secret secret;
  PublicKey public_key{};
};
KeyPair make_key_pair(const Random& random);
PublicKey public_key_of(const Secret& secret);

/// X25519. False where the other's key is one of the few that make the result known to everybody.
[[nodiscard]] bool agree(const Secret& own, const PublicKey& other, Secret& out);

/// Ed25519, of a secret as Secret has it.
PublicKey signing_public_key(const Secret& secret);
std::array<std::uint8_t, kSignatureBytes> sign(const Secret& secret,
                                               std::span<const std::uint8_t> message);
[[nodiscard]] bool verify(const PublicKey& key, std::span<const std::uint8_t> message,
                          std::span<const std::uint8_t> signature);

Hash hash(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second = {});
/// HMAC over BLAKE2b-512.
Hash hmac(std::span<const std::uint8_t> key, std::span<const std::uint8_t> first,
          std::span<const std::uint8_t> second = {});
/// BLAKE2b with a key, of 16 bytes.
std::array<std::uint8_t, 16> mac16(const Secret& key, std::span<const std::uint8_t> message);
/// Of equal length, in constant time.
bool equal(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);
/// The key that follows `key`; there is no way back.
Secret next_key(const Secret& key);

/// ChaCha20-Poly1305 (IETF): `out` has plain.size() + kTagBytes. The nonce is four zero bytes and
/// the counter, so no counter may be used twice with one key.
void seal(const Secret& key, std::uint64_t counter, std::span<const std::uint8_t> header,
          std::span<const std::uint8_t> plain, std::span<std::uint8_t> out);
/// `out` has sealed.size() - kTagBytes. False, and nothing to be read in `out`, where key, counter,
/// header or bytes are others than those that were sealed.
[[nodiscard]] bool open(const Secret& key, std::uint64_t counter,
                        std::span<const std::uint8_t> header, std::span<const std::uint8_t> sealed,
                        std::span<std::uint8_t> out);

}  // namespace tandem::net::crypto
