// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_security.h"

#include <map>
#include <string_view>
#include <utility>

#include "address.h"
#include "address_limiter.h"
#include "noise.h"
#include "octets.h"
#include "stream_protection.h"
#include "wire.h"

namespace tandem::net {

namespace {

// Connections that may ask for keys. Above what UDP allows: each failure costs a redial here, and a
// mesh of sixteen on one machine comes from one address.
constexpr double kRate = 8.0;  // per s and address
constexpr double kBurst = 32.0;
constexpr double kTotal = 1000.0;  // per s

/// Both ends hash what they believe to be doing: nothing of UDP, nor of another version, fits.
std::vector<std::uint8_t> tcp_prologue() {
  constexpr std::string_view kLabel = "tandem tcp";
  std::vector<std::uint8_t> out(kLabel.begin(), kLabel.end());
  out.push_back(static_cast<std::uint8_t>(kKeyVersion));
  out.push_back(static_cast<std::uint8_t>(kKeyVersion >> 8));
  return out;
}

class Cipher final : public LinkCipher {
 public:
  Cipher(const crypto::Secret& send, const crypto::Secret& receive, std::int64_t now)
      : sealer_(send, now), opener_(receive) {}

  bool seal(std::span<const std::byte> frames, std::int64_t now,
            std::vector<std::byte>& out) override {
    return sealer_.seal(frames, now, out);
  }
  std::optional<std::span<const std::byte>> open(std::span<const std::byte> frame) override {
    return opener_.open(frame);
  }

 private:
  StreamSealer sealer_;
  StreamOpener opener_;
};

class Exchange final : public KeyExchange {
 public:
  Exchange(const crypto::Secret& session_key, const crypto::KeyPair& identity,
           const crypto::Random& random)
      : noise_(session_key, identity, tcp_prologue(), random), message_(noise_.first_message({})) {}

  std::span<const std::byte> message() const override { return as_bytes(message_); }
  std::optional<LinkKeys> finish(std::span<const std::byte> answer, std::int64_t now) override {
    const auto result = noise_.second_message(octets(answer));
    if (!result || !result->payload.empty()) return {};
    return LinkKeys{
        .cipher = std::make_unique<Cipher>(result->keys.initiator, result->keys.responder, now),
        .remote = result->remote,
        .message = {}};
  }

 private:
  NoiseInitiator noise_;
  std::vector<std::uint8_t> message_;
};

class Security final : public TcpSecurity {
 public:
  explicit Security(const TcpOptions& options)
      : random_(crypto::system_random()),
        session_key_(*options.session_key),
        identity_(crypto::make_key_pair(random_)),
        limiter_(crypto::make_key_pair(random_).secret, kRate, kBurst, kTotal) {
    if (options.identity) {
      identity_.secret = crypto::Secret(*options.identity);
      identity_.public_key = crypto::public_key_of(identity_.secret);
    }
    for (const TrustedPeer& each : options.trusted) trusted_[each.peer] = each.public_key;
  }

  bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now) override {
    return limiter_.allow({.ip = ip, .port = 1}, now);  // ports do not count, but 0 has a meaning
  }

  std::unique_ptr<KeyExchange> ask() override {
    return std::make_unique<Exchange>(session_key_, identity_, random_);
  }

  std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) override {
    NoiseResponder noise(session_key_, tcp_prologue());
    const auto first = noise.first_message(octets(question));
    if (!first || !first->payload.empty()) return {};
    const auto second = noise.second_message(identity_, random_, {});
    if (!second) return {};
    const auto message = as_bytes(second->message);
    return LinkKeys{
        .cipher = std::make_unique<Cipher>(second->keys.responder, second->keys.initiator, now),
        .remote = first->remote,
        .message = {message.begin(), message.end()}};
  }

  bool trusts(PeerId peer, const Key& remote) const override {
    if (trusted_.empty()) return true;
    const auto known = trusted_.find(peer);
    return known != trusted_.end() && known->second == remote;
  }

 private:
  crypto::Random random_;
  crypto::Secret session_key_;
  crypto::KeyPair identity_;
  std::map<PeerId, crypto::PublicKey> trusted_;
  AddressLimiter limiter_;
};

}  // namespace

bool has_protection() { return true; }

std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& options) {
  if (!options.session_key) return nullptr;
  return std::make_unique<Security>(options);
}

}  // namespace tandem::net
