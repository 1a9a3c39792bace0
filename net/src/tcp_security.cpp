// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_security.h"

#include <string_view>
#include <utility>

#include "address.h"
#include "address_limiter.h"
#include "credentials.h"
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

std::vector<std::uint8_t> own_badge(const Credentials& own) {
  std::vector<std::byte> bytes;
  encode(own.badge(), bytes);
  const auto view = octets(std::span<const std::byte>(bytes));
  return {view.begin(), view.end()};
}

std::vector<std::byte> copy(std::span<const std::uint8_t> from) {
  const auto bytes = as_bytes(from);
  return {bytes.begin(), bytes.end()};
}

class Exchange final : public KeyExchange {
 public:
  Exchange(const crypto::Secret& session_key, const Credentials& own, const crypto::Random& random)
      : noise_(session_key, own.identity, tcp_prologue(), random),
        message_(noise_.first_message(own_badge(own))) {}

  std::span<const std::byte> message() const override { return as_bytes(message_); }
  std::optional<LinkKeys> finish(std::span<const std::byte> answer, std::int64_t now) override {
    const auto result = noise_.second_message(octets(answer));
    if (!result) return {};
    return LinkKeys{
        .cipher = std::make_unique<Cipher>(result->keys.initiator, result->keys.responder, now),
        .remote = result->remote,
        .badge = copy(result->payload),
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
        session_(options.scene_hash),
        limiter_(crypto::make_key_pair(random_).secret, kRate, kBurst, kTotal) {
    own_.session_key = crypto::Secret(*options.session_key);
    own_.identity = crypto::make_key_pair(random_);
    if (options.identity) {
      own_.identity.secret = crypto::Secret(*options.identity);
      own_.identity.public_key = crypto::public_key_of(own_.identity.secret);
    }
    for (const TrustedPeer& each : options.trusted) own_.trusted[each.peer] = each.public_key;
    own_.organiser = options.organiser;
    own_.certificate = options.certificate;
    own_.complete(options.self);
  }

  bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now) override {
    return limiter_.allow({.ip = ip, .port = 1}, now);  // ports do not count, but 0 has a meaning
  }

  std::unique_ptr<KeyExchange> ask(std::uint64_t attempt) override {
    return std::make_unique<Exchange>(own_.key(attempt % own_.key_count()), own_, random_);
  }

  std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) override {
    for (std::size_t key = 0; key < own_.key_count(); ++key) {
      NoiseResponder noise(own_.key(key), tcp_prologue());
      const auto first = noise.first_message(octets(question));
      if (!first) continue;
      const auto second = noise.second_message(own_.identity, random_, own_badge(own_));
      if (!second) return {};
      return LinkKeys{
          .cipher = std::make_unique<Cipher>(second->keys.responder, second->keys.initiator, now),
          .remote = first->remote,
          .badge = copy(first->payload),
          .message = copy(second->message)};
    }
    return {};
  }

  LinkMember judge(PeerId peer, const Key& remote,
                   std::span<const std::byte> badge) const override {
    const auto read = decode_badge(badge);
    if (!read) return {.key = remote, .refusal = "not a key exchange of this protocol"};
    const auto answer = own_.judge(peer, remote, *read, session_);
    return {.key = remote,
            .role = answer.member.role,
            .bound = answer.member.bound,
            .expires = answer.member.expires,
            .refusal = answer.verdict == Verdict::Welcome ? "" : describe(answer.verdict)};
  }

  std::string expelled(const LinkMember& member) const override {
    if (own_.stands({.key = member.key, .expires = member.expires})) return {};
    return describe(own_.is_revoked(member.key) ? Verdict::Revoked : Verdict::Expired);
  }

  Changed change_group(std::span<const std::byte> signed_change) override {
    switch (own_.change(signed_change, session_)) {
      case Credentials::Changed::Yes:
        return Changed::Yes;
      case Credentials::Changed::Known:
        return Changed::Known;
      case Credentials::Changed::Forged:
        break;
    }
    return own_.organiser ? Changed::Forged : Changed::Known;
  }
  std::span<const std::byte> group_change() const override { return own_.group_change; }
  std::uint64_t group() const override { return own_.group; }

 private:
  crypto::Random random_;
  const std::uint64_t session_;
  Credentials own_;
  AddressLimiter limiter_;
};

}  // namespace

bool has_protection() { return true; }

std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& options) {
  if (!options.session_key) return nullptr;
  return std::make_unique<Security>(options);
}

}  // namespace tandem::net
