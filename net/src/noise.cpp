// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "noise.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace tandem::net {

namespace {

using crypto::Hash;
using crypto::kKeyBytes;
using crypto::kTagBytes;
using crypto::PublicKey;
using crypto::Secret;

constexpr std::string_view kProtocol = "Noise_IXpsk0_25519_ChaChaPoly_BLAKE2b";

Secret truncated(const Hash& hash) { return Secret(std::span(hash).first<kKeyBytes>()); }

/// HKDF of the framework, Sec. 4.3.
std::array<Hash, 3> derive(const Hash& chain, std::span<const std::uint8_t> material) {
  constexpr std::array<std::uint8_t, 3> kCounters{1, 2, 3};
  Hash key = crypto::hmac(chain, material);
  std::array<Hash, 3> out;
  out[0] = crypto::hmac(key, std::span(kCounters).subspan(0, 1));
  out[1] = crypto::hmac(key, out[0], std::span(kCounters).subspan(1, 1));
  out[2] = crypto::hmac(key, out[1], std::span(kCounters).subspan(2, 1));
  crypto::wipe(key);
  return out;
}

void wipe(std::array<Hash, 3>& hashes) {
  for (Hash& hash : hashes) crypto::wipe(hash);
}

PublicKey to_key(std::span<const std::uint8_t> bytes) {
  PublicKey out{};
  std::copy_n(bytes.begin(), out.size(), out.begin());
  return out;
}

bool mix_agreement(NoiseState& state, const Secret& own, const PublicKey& other) {
  Secret shared;
  if (!crypto::agree(own, other, shared)) return false;
  state.mix_key(shared.bytes());
  return true;
}

/// The token "e" of patterns with a pre-shared key.
void mix_ephemeral(NoiseState& state, const PublicKey& key) {
  state.mix_hash(key);
  state.mix_key(key);
}

}  // namespace

NoiseState::NoiseState(std::string_view protocol, std::span<const std::uint8_t> prologue) {
  crypto::initialise();
  if (protocol.size() > hash_.size())
    throw std::length_error("NoiseState: protocol must have at most 64 bytes");
  std::copy(protocol.begin(), protocol.end(), hash_.begin());
  chain_ = hash_;
  mix_hash(prologue);
}

void NoiseState::mix_hash(std::span<const std::uint8_t> data) { hash_ = crypto::hash(hash_, data); }

void NoiseState::mix_key(std::span<const std::uint8_t> material) {
  auto derived = derive(chain_, material);
  chain_ = derived[0];
  key_ = truncated(derived[1]);
  counter_ = 0;
  wipe(derived);
}

void NoiseState::mix_key_and_hash(const Secret& psk) {
  auto derived = derive(chain_, psk.bytes());
  chain_ = derived[0];
  mix_hash(derived[1]);
  key_ = truncated(derived[2]);
  counter_ = 0;
  wipe(derived);
}

void NoiseState::encrypt_and_hash(std::span<const std::uint8_t> plain,
                                  std::vector<std::uint8_t>& out) {
  const std::size_t at = out.size();
  out.resize(at + plain.size() + kTagBytes);
  const auto sealed = std::span(out).subspan(at);
  crypto::seal(key_, counter_++, hash_, plain, sealed);
  mix_hash(sealed);
}

std::optional<std::vector<std::uint8_t>> NoiseState::decrypt_and_hash(
    std::span<const std::uint8_t> sealed) {
  if (sealed.size() < kTagBytes) return {};
  std::vector<std::uint8_t> plain(sealed.size() - kTagBytes);
  if (!crypto::open(key_, counter_, hash_, sealed, plain)) return {};
  ++counter_;
  mix_hash(sealed);
  return plain;
}

NoiseState::Keys NoiseState::split() const {
  auto derived = derive(chain_, {});
  Keys out{.initiator = truncated(derived[0]), .responder = truncated(derived[1])};
  wipe(derived);
  return out;
}

NoiseInitiator::NoiseInitiator(const Secret& psk, const crypto::KeyPair& own,
                               std::span<const std::uint8_t> prologue, const crypto::Random& random)
    : state_(kProtocol, prologue), static_(own), ephemeral_(crypto::make_key_pair(random)) {
  state_.mix_key_and_hash(psk);
}

std::vector<std::uint8_t> NoiseInitiator::first_message(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> out(ephemeral_.public_key.begin(), ephemeral_.public_key.end());
  mix_ephemeral(state_, ephemeral_.public_key);
  state_.encrypt_and_hash(static_.public_key, out);
  state_.encrypt_and_hash(payload, out);
  return out;
}

std::optional<NoiseInitiator::Result> NoiseInitiator::second_message(
    std::span<const std::uint8_t> message) const {
  if (message.size() < kNoiseOverhead) return {};
  NoiseState state = state_;
  const PublicKey ephemeral = to_key(message);
  mix_ephemeral(state, ephemeral);
  if (!mix_agreement(state, ephemeral_.secret, ephemeral)) return {};
  if (!mix_agreement(state, static_.secret, ephemeral)) return {};
  const auto remote = state.decrypt_and_hash(message.subspan(32, 32 + kTagBytes));
  if (!remote) return {};
  const PublicKey remote_static = to_key(*remote);
  if (!mix_agreement(state, ephemeral_.secret, remote_static)) return {};
  auto payload = state.decrypt_and_hash(message.subspan(64 + kTagBytes));
  if (!payload) return {};
  return Result{.keys = state.split(), .remote = remote_static, .payload = std::move(*payload)};
}

NoiseResponder::NoiseResponder(const Secret& psk, std::span<const std::uint8_t> prologue)
    : state_(kProtocol, prologue), psk_(psk) {}

std::optional<NoiseResponder::First> NoiseResponder::first_message(
    std::span<const std::uint8_t> message) {
  if (message.size() < kNoiseOverhead) return {};
  state_.mix_key_and_hash(psk_);
  remote_ephemeral_ = to_key(message);
  mix_ephemeral(state_, remote_ephemeral_);
  const auto remote = state_.decrypt_and_hash(message.subspan(32, 32 + kTagBytes));
  if (!remote) return {};
  remote_static_ = to_key(*remote);
  auto payload = state_.decrypt_and_hash(message.subspan(64 + kTagBytes));
  if (!payload) return {};
  return First{.remote = remote_static_, .payload = std::move(*payload)};
}

std::optional<NoiseResponder::Result> NoiseResponder::second_message(
    const crypto::KeyPair& own, const crypto::Random& random,
    std::span<const std::uint8_t> payload) {
  const crypto::KeyPair ephemeral = crypto::make_key_pair(random);
  std::vector<std::uint8_t> out(ephemeral.public_key.begin(), ephemeral.public_key.end());
  mix_ephemeral(state_, ephemeral.public_key);
  if (!mix_agreement(state_, ephemeral.secret, remote_ephemeral_)) return {};
  if (!mix_agreement(state_, ephemeral.secret, remote_static_)) return {};
  state_.encrypt_and_hash(own.public_key, out);
  if (!mix_agreement(state_, own.secret, remote_ephemeral_)) return {};
  state_.encrypt_and_hash(payload, out);
  return Result{.keys = state_.split(), .message = std::move(out)};
}

}  // namespace tandem::net
