// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "crypto.h"

namespace tandem::net {

/// Transcript hash and keys of a handshake: the SymmetricState of the Noise Protocol Framework,
/// revision 34, with 25519, ChaChaPoly and BLAKE2b.
class NoiseState {
 public:
  NoiseState(std::string_view protocol, std::span<const std::uint8_t> prologue);

  void mix_hash(std::span<const std::uint8_t> data);
  void mix_key(std::span<const std::uint8_t> material);
  void mix_key_and_hash(const crypto::Secret& psk);
  /// Appends to `out`.
  void encrypt_and_hash(std::span<const std::uint8_t> plain, std::vector<std::uint8_t>& out);
  std::optional<std::vector<std::uint8_t>> decrypt_and_hash(std::span<const std::uint8_t> sealed);

  struct Keys {
    crypto::Secret initiator;  // for packets of the initiator
    crypto::Secret responder;
  };
  Keys split() const;

 private:
  crypto::Hash hash_{};
  crypto::Hash chain_{};
  crypto::Secret key_;
  std::uint64_t counter_ = 0;
};

/// Noise_IXpsk0: both ends know the session key and send their static public keys under it; in the
/// end each knows that the other has the secret of its key.
///   -> psk, e, s      <- e, ee, se, s, es
/// The initiator is authenticated by its first packet under the keys, not by its message, which may
/// be a recording.
class NoiseInitiator {
 public:
  NoiseInitiator(const crypto::Secret& psk, const crypto::KeyPair& own,
                 std::span<const std::uint8_t> prologue, const crypto::Random& random);

  std::vector<std::uint8_t> first_message(std::span<const std::uint8_t> payload);

  struct Result {
    NoiseState::Keys keys;
    crypto::PublicKey remote{};
    std::vector<std::uint8_t> payload;
  };
  /// Leaves this object unchanged if the message is not the other end's.
  std::optional<Result> second_message(std::span<const std::uint8_t> message) const;

 private:
  NoiseState state_;
  crypto::KeyPair static_;
  crypto::KeyPair ephemeral_;
};

class NoiseResponder {
 public:
  NoiseResponder(const crypto::Secret& psk, std::span<const std::uint8_t> prologue);

  struct First {
    crypto::PublicKey remote{};
    std::vector<std::uint8_t> payload;
  };
  /// Symmetric work only. Call it once.
  std::optional<First> first_message(std::span<const std::uint8_t> message);

  struct Result {
    NoiseState::Keys keys;
    std::vector<std::uint8_t> message;
  };
  /// After first_message(). None if the other's keys are bad.
  std::optional<Result> second_message(const crypto::KeyPair& own, const crypto::Random& random,
                                       std::span<const std::uint8_t> payload);

 private:
  NoiseState state_;
  crypto::Secret psk_;
  crypto::PublicKey remote_ephemeral_{};
  crypto::PublicKey remote_static_{};
};

constexpr std::size_t kNoiseOverhead = 32 + 32 + crypto::kTagBytes + crypto::kTagBytes;

}  // namespace tandem::net
