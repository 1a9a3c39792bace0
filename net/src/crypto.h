// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace tandem::net::crypto {

// The parts of libsodium in use. Only crypto.cpp includes it; no_crypto.cpp replaces it in builds
// without libsodium.

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kTagBytes = 16;
constexpr std::size_t kHashBytes = 64;
constexpr std::size_t kSignatureBytes = 64;

using PublicKey = std::array<std::uint8_t, kKeyBytes>;  // X25519
using Hash = std::array<std::uint8_t, kHashBytes>;      // BLAKE2b-512

/// Whether this build has libsodium. Without it initialise() throws, and nothing works.
bool is_available();
/// Selects the fastest code for the processor. Call it first; repeated calls are harmless. Throws
/// std::runtime_error if the library cannot be initialised.
void initialise();

/// Overwrites memory; the compiler does not remove it.
void wipe(std::span<std::uint8_t> bytes);

/// 32 secret bytes, overwritten on destruction.
class Secret {
 public:
  Secret() = default;
  explicit Secret(std::span<const std::uint8_t, kKeyBytes> bytes);
  Secret(const Secret&) = default;
  Secret& operator=(const Secret&) = default;
  ~Secret() { wipe(bytes_); }

  std::span<std::uint8_t, kKeyBytes> bytes() { return bytes_; }
  std::span<const std::uint8_t, kKeyBytes> bytes() const { return bytes_; }
  /// Constant time.
  friend bool operator==(const Secret& a, const Secret& b);

 private:
  std::array<std::uint8_t, kKeyBytes> bytes_{};
};

/// Fills with unpredictable bytes. Only tests may supply their own generator.
using Random = std::function<void(std::span<std::uint8_t>)>;
/// The system's generator. Calls initialise().
Random system_random();
std::uint64_t random_number(const Random& random);

struct KeyPair {
  Secret secret;
  PublicKey public_key{};
};
KeyPair make_key_pair(const Random& random);
PublicKey public_key_of(const Secret& secret);

/// X25519. False if the other key is one of the few for which the result is public.
[[nodiscard]] bool agree(const Secret& own, const PublicKey& other, Secret& out);

/// Ed25519; the secret is a Secret.
PublicKey signing_public_key(const Secret& secret);
std::array<std::uint8_t, kSignatureBytes> sign(const Secret& secret,
                                               std::span<const std::uint8_t> message);
[[nodiscard]] bool verify(const PublicKey& key, std::span<const std::uint8_t> message,
                          std::span<const std::uint8_t> signature);

Hash hash(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second = {});
/// HMAC over BLAKE2b-512.
Hash hmac(std::span<const std::uint8_t> key, std::span<const std::uint8_t> first,
          std::span<const std::uint8_t> second = {});
/// Keyed BLAKE2b, 16 bytes.
std::array<std::uint8_t, 16> mac16(const Secret& key, std::span<const std::uint8_t> message);
/// Operands of equal length, constant time.
bool equal(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);
/// The successor of `key`; irreversible.
Secret next_key(const Secret& key);

/// ChaCha20-Poly1305 (IETF): `out` has plain.size() + kTagBytes. The nonce is four zero bytes and
/// the counter: never use a counter twice with one key.
void seal(const Secret& key, std::uint64_t counter, std::span<const std::uint8_t> header,
          std::span<const std::uint8_t> plain, std::span<std::uint8_t> out);
/// `out` has sealed.size() - kTagBytes. False, with unusable `out`, if key, counter, header or
/// bytes differ from those sealed.
[[nodiscard]] bool open(const Secret& key, std::uint64_t counter,
                        std::span<const std::uint8_t> header, std::span<const std::uint8_t> sealed,
                        std::span<std::uint8_t> out);

}  // namespace tandem::net::crypto
