// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "crypto.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>

namespace tandem::net::crypto {

namespace {

constexpr std::size_t kHmacBlock = 128;  // of BLAKE2b

std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES> nonce(std::uint64_t counter) {
  std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES> out{};
  for (std::size_t i = 0; i < 8; ++i) out[4 + i] = static_cast<std::uint8_t>(counter >> (8 * i));
  return out;
}

static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == kKeyBytes);
static_assert(crypto_aead_chacha20poly1305_ietf_ABYTES == kTagBytes);
static_assert(crypto_generichash_BYTES_MAX == kHashBytes);
static_assert(crypto_scalarmult_BYTES == kKeyBytes);
static_assert(crypto_sign_BYTES == kSignatureBytes && crypto_sign_SEEDBYTES == kKeyBytes);

}  // namespace

bool is_available() { return true; }

void wipe(std::span<std::uint8_t> bytes) { sodium_memzero(bytes.data(), bytes.size()); }

Secret::Secret(std::span<const std::uint8_t, kKeyBytes> bytes) {
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
}

bool operator==(const Secret& a, const Secret& b) { return equal(a.bytes_, b.bytes_); }

void initialise() {
  // sodium_init() is idempotent and thread-safe.
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
}

Random system_random() {
  initialise();
  return [](std::span<std::uint8_t> out) { randombytes_buf(out.data(), out.size()); };
}

std::uint64_t random_number(const Random& random) {
  std::array<std::uint8_t, 8> bytes{};
  random(bytes);
  std::uint64_t out = 0;
  for (const std::uint8_t byte : bytes) out = out << 8 | byte;
  return out;
}

KeyPair make_key_pair(const Random& random) {
  KeyPair out;
  random(out.secret.bytes());
  out.public_key = public_key_of(out.secret);
  return out;
}

PublicKey public_key_of(const Secret& secret) {
  PublicKey out;
  crypto_scalarmult_base(out.data(), secret.bytes().data());
  return out;
}

bool agree(const Secret& own, const PublicKey& other, Secret& out) {
  return crypto_scalarmult(out.bytes().data(), own.bytes().data(), other.data()) == 0;
}

namespace {

struct SigningKeys {
  std::array<std::uint8_t, crypto_sign_SECRETKEYBYTES> secret{};
  PublicKey public_key{};
  ~SigningKeys() { wipe(secret); }
};

void expand(const Secret& seed, SigningKeys& out) {
  crypto_sign_seed_keypair(out.public_key.data(), out.secret.data(), seed.bytes().data());
}

}  // namespace

PublicKey signing_public_key(const Secret& secret) {
  SigningKeys keys;
  expand(secret, keys);
  return keys.public_key;
}

std::array<std::uint8_t, kSignatureBytes> sign(const Secret& secret,
                                               std::span<const std::uint8_t> message) {
  SigningKeys keys;
  expand(secret, keys);
  std::array<std::uint8_t, kSignatureBytes> out{};
  crypto_sign_detached(out.data(), nullptr, message.data(), message.size(), keys.secret.data());
  return out;
}

bool verify(const PublicKey& key, std::span<const std::uint8_t> message,
            std::span<const std::uint8_t> signature) {
  return signature.size() == kSignatureBytes &&
         crypto_sign_verify_detached(signature.data(), message.data(), message.size(),
                                     key.data()) == 0;
}

Hash hash(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second) {
  Hash out;
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, out.size());
  crypto_generichash_update(&state, first.data(), first.size());
  crypto_generichash_update(&state, second.data(), second.size());
  crypto_generichash_final(&state, out.data(), out.size());
  return out;
}

Hash hmac(std::span<const std::uint8_t> key, std::span<const std::uint8_t> first,
          std::span<const std::uint8_t> second) {
  std::array<std::uint8_t, kHmacBlock> pad{};
  if (key.size() > pad.size()) throw std::length_error("hmac: key must have at most 128 bytes");
  std::copy(key.begin(), key.end(), pad.begin());
  for (std::uint8_t& byte : pad) byte ^= 0x36;
  Hash inner;
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, inner.size());
  crypto_generichash_update(&state, pad.data(), pad.size());
  crypto_generichash_update(&state, first.data(), first.size());
  crypto_generichash_update(&state, second.data(), second.size());
  crypto_generichash_final(&state, inner.data(), inner.size());
  for (std::uint8_t& byte : pad) byte ^= 0x36 ^ 0x5c;
  const Hash out = hash(pad, inner);
  wipe(pad);
  return out;
}

std::array<std::uint8_t, 16> mac16(const Secret& key, std::span<const std::uint8_t> message) {
  std::array<std::uint8_t, 16> out;
  crypto_generichash(out.data(), out.size(), message.data(), message.size(), key.bytes().data(),
                     key.bytes().size());
  return out;
}

bool equal(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

Secret next_key(const Secret& key) {
  constexpr std::array<std::uint8_t, 13> kLabel{'t', 'a', 'n', 'd', 'e', 'm', ' ',
                                                'r', 'e', 'k', 'e', 'y', '1'};
  Secret out;
  crypto_generichash(out.bytes().data(), kKeyBytes, kLabel.data(), kLabel.size(),
                     key.bytes().data(), kKeyBytes);
  return out;
}

void seal(const Secret& key, std::uint64_t counter, std::span<const std::uint8_t> header,
          std::span<const std::uint8_t> plain, std::span<std::uint8_t> out) {
  if (out.size() != plain.size() + kTagBytes)
    throw std::length_error("seal: output must have the size of the input and 16 bytes");
  const auto number = nonce(counter);
  crypto_aead_chacha20poly1305_ietf_encrypt(out.data(), nullptr, plain.data(), plain.size(),
                                            header.data(), header.size(), nullptr, number.data(),
                                            key.bytes().data());
}

bool open(const Secret& key, std::uint64_t counter, std::span<const std::uint8_t> header,
          std::span<const std::uint8_t> sealed, std::span<std::uint8_t> out) {
  if (sealed.size() < kTagBytes || out.size() != sealed.size() - kTagBytes) return false;
  const auto number = nonce(counter);
  return crypto_aead_chacha20poly1305_ietf_decrypt(out.data(), nullptr, nullptr, sealed.data(),
                                                   sealed.size(), header.data(), header.size(),
                                                   number.data(), key.bytes().data()) == 0;
}

}  // namespace tandem::net::crypto
