// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "noise.h"

#include <algorithm>

#include "protocol_support.h"
#include "support/catch.h"

namespace noise_test {

using namespace tandem::net;
using namespace protocol;

namespace {

using Octets = std::vector<std::uint8_t>;

/// first, first + 1, ...
crypto::Secret counting(std::uint8_t first) {
  crypto::Secret out;
  for (std::uint8_t& byte : out.bytes()) byte = first++;
  return out;
}

crypto::KeyPair pair_of(const crypto::Secret& secret) {
  return {.secret = secret, .public_key = crypto::public_key_of(secret)};
}

crypto::Secret secret_of(const char* digits) {
  const Octets bytes = unhex(digits);
  return crypto::Secret(std::span(bytes).first<32>());
}

/// A generator whose only output is a key.
crypto::Random giving(const crypto::Secret& secret) {
  return [secret](std::span<std::uint8_t> out) {
    std::copy(secret.bytes().begin(), secret.bytes().end(), out.begin());
  };
}

Octets octets_of(const char* characters) {
  Octets out;
  for (; *characters != 0; ++characters) out.push_back(static_cast<std::uint8_t>(*characters));
  return out;
}

}  // namespace

TEST_CASE("noise: hashing and mixing give the published messages of NNpsk0", "[net][golden]") {
  // Test vector of Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b of the cacophony library. psk, e, ee are
  // all tokens of ours but for the static keys.
  NoiseState state("Noise_NNpsk0_25519_ChaChaPoly_BLAKE2b", unhex("4a6f686e2047616c74"));
  const auto one =
      pair_of(secret_of("893e28b9dc6ca8d611ab664754b8ceb7bac5117349a4439a6b0569da977c464a"));
  const auto other =
      pair_of(secret_of("bbdb4cdbd309f1a1f2e1456967fe288cadd6f712d65dc7b7793d5e63da6b375b"));
  state.mix_key_and_hash(
      secret_of("54686973206973206d7920417573747269616e20706572737065637469766521"));
  Octets message(one.public_key.begin(), one.public_key.end());
  state.mix_hash(one.public_key);
  state.mix_key(one.public_key);
  state.encrypt_and_hash(unhex("4c756477696720766f6e204d69736573"), message);
  CHECK(message == unhex("ca35def5ae56cec33dc2036731ab14896bc4c75dbb07a61f879f8e3afa4c7944"
                         "ed63df2f5a12aee1185ee9c50305f2ecf12421dcb53c047a63b784cf7c54a105"));

  message.assign(other.public_key.begin(), other.public_key.end());
  state.mix_hash(other.public_key);
  state.mix_key(other.public_key);
  crypto::Secret shared;
  REQUIRE(crypto::agree(one.secret, other.public_key, shared));
  state.mix_key(shared.bytes());
  state.encrypt_and_hash(unhex("4d757272617920526f746862617264"), message);
  CHECK(message == unhex("95ebc60d2b1fa672c1f46a8aa265ef51bfe38e7ccb39ec5be34069f144808843"
                         "0e0fe7d5c0c9b92f7478716c8852f1b4f389edb75e3ebe546fafafd5b6f0f7"));

  const auto plain = unhex("462e20412e20486179656b");
  Octets sealed(plain.size() + crypto::kTagBytes);
  crypto::seal(state.split().initiator, 0, {}, plain, sealed);
  CHECK(sealed == unhex("0fe04b26dcfbb69f8a6a94c61f1a26ef88769218d32f5d17c068a6"));
}

TEST_CASE("noise: the handshake is that of another implementation", "[net][golden]") {
  // IXpsk0 from the text of the framework in Python, on OpenSSL and hashlib.
  const auto prologue = octets_of("prologue");
  NoiseInitiator initiator(counting(128), pair_of(counting(0)), prologue, giving(counting(32)));
  NoiseResponder responder(counting(128), prologue);
  const auto first = initiator.first_message(octets_of("hello"));
  CHECK(first == unhex("358072d6365880d1aeea329adf9121383851ed21a28e3b75e965d0d2cd166254"
                       "9b50c12e47b27fe3f7267947adc85cd5e6dac55a0a527de01464bc77ed7caa02"
                       "9f96909bea7e2aed6fa200a9f8679454a57df9fb397e8d6c5fe7650b6f0ee09c"
                       "70474735da"));
  const auto read = responder.first_message(first);
  REQUIRE(read);
  CHECK(read->remote == pair_of(counting(0)).public_key);
  CHECK(read->payload == octets_of("hello"));
  const auto second =
      responder.second_message(pair_of(counting(64)), giving(counting(96)), octets_of("welcome"));
  REQUIRE(second);
  CHECK(second->message == unhex("675dd574ed7789310b3d2e7681f3790b466c773b1521fecf36577958371ea52f"
                                 "2be4cb33c8e0e249f9f06ec6718c0acc7a5cce00d64e03f7b19feba62c62d42c"
                                 "5bde98cf16c441bfac6cbc99da57c799b67d20d0894a19e35a7b6a5122b9ecdb"
                                 "6e6ac665107e66"));
  CHECK(second->keys.initiator ==
        secret_of("91753ac71ee5ab7ccf2908bfa22b7383a0c1584280aa517601e5913de3528f63"));
  CHECK(second->keys.responder ==
        secret_of("12e6e1312ecebbe6193ff0e106f35d41db0af88cd52d1ccae9935ac2d3ab0240"));

  const auto done = initiator.second_message(second->message);
  REQUIRE(done);
  CHECK(done->remote == pair_of(counting(64)).public_key);
  CHECK(done->payload == octets_of("welcome"));
  CHECK(done->keys.initiator == second->keys.initiator);
  CHECK(done->keys.responder == second->keys.responder);
}

TEST_CASE("noise: any bit of either message that is changed is noticed", "[net][fault]") {
  const auto prologue = octets_of("prologue");
  NoiseInitiator initiator(secret(9), pair_of(secret(1)), prologue, seeded(2));
  const auto first = initiator.first_message(octets_of("hello"));
  for (std::size_t bit = 0; bit < 8 * first.size(); ++bit) {
    Octets bad = first;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    NoiseResponder responder(secret(9), prologue);
    // Bit 255 of a public key means nothing to X25519; the hash of the message has it all the same.
    CHECK_FALSE(responder.first_message(bad));
  }
  for (std::size_t size = 0; size < first.size(); ++size) {
    NoiseResponder responder(secret(9), prologue);
    CHECK_FALSE(responder.first_message(std::span(first).first(size)));
  }
  NoiseResponder responder(secret(9), prologue);
  REQUIRE(responder.first_message(first));
  const auto second = responder.second_message(pair_of(secret(3)), seeded(4), octets_of("welcome"));
  REQUIRE(second);
  for (std::size_t bit = 0; bit < 8 * second->message.size(); bit += 3) {
    Octets bad = second->message;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    CHECK_FALSE(initiator.second_message(bad));
  }
  CHECK(initiator.second_message(second->message));
  NoiseResponder stranger(secret(8), prologue);
  CHECK_FALSE(stranger.first_message(first));
}

TEST_CASE("noise: keys that make the secret known to everybody are refused", "[net][fault]") {
  crypto::Secret shared;
  CHECK_FALSE(crypto::agree(secret(1), crypto::PublicKey{}, shared));
  crypto::PublicKey one{};
  one[0] = 1;
  CHECK_FALSE(crypto::agree(secret(1), one, shared));
}

}  // namespace noise_test
