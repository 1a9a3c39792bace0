// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_security.h"

#include <string_view>

#include "octets.h"
#include "wire.h"

namespace tandem::net {

namespace {

// Connections that may ask for keys. More than over UDP: each failure costs a redial here, and a
// mesh of sixteen on one machine comes from one address.
constexpr double kRate = 8.0;  // per s and address
constexpr double kBurst = 32.0;
constexpr double kTotal = 1000.0;  // per s

/// Hashed by both ends: no message of UDP or of another version fits.
std::vector<std::uint8_t> tcp_prologue() {
  constexpr std::string_view kLabel = "tandem tcp";
  std::vector<std::uint8_t> out(kLabel.begin(), kLabel.end());
  out.push_back(static_cast<std::uint8_t>(kKeyVersion));
  out.push_back(static_cast<std::uint8_t>(kKeyVersion >> 8));
  return out;
}

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

}  // namespace

KeyExchange::KeyExchange(const crypto::Secret& session_key, const Credentials& own,
                         const crypto::Random& random)
    : noise_(session_key, own.identity, tcp_prologue(), random),
      message_(noise_.first_message(own_badge(own))) {}

std::optional<LinkKeys> KeyExchange::finish(std::span<const std::byte> answer,
                                            std::int64_t now) const {
  const auto result = noise_.second_message(octets(answer));
  if (!result) return {};
  return LinkKeys{
      .cipher = std::make_unique<LinkCipher>(result->keys.initiator, result->keys.responder, now),
      .remote = result->remote,
      .badge = copy(result->payload),
      .message = {}};
}

TcpSecurity::TcpSecurity(const TcpOptions& options)
    : random_(crypto::system_random()),
      session_(options.scene_hash),
      own_(credentials_of(options, *options.session_key)),
      limiter_(crypto::make_key_pair(random_).secret, kRate, kBurst, kTotal) {
  own_.complete(options.self);
}

bool TcpSecurity::allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now) {
  return limiter_.allow({.ip = ip, .port = 1}, now);  // ports do not count, but 0 has a meaning
}

std::unique_ptr<KeyExchange> TcpSecurity::ask(std::uint64_t attempt) const {
  return std::make_unique<KeyExchange>(own_.key(attempt % own_.key_count()), own_, random_);
}

std::optional<LinkKeys> TcpSecurity::answer(std::span<const std::byte> question,
                                            std::int64_t now) const {
  for (std::size_t key = 0; key < own_.key_count(); ++key) {
    NoiseResponder noise(own_.key(key), tcp_prologue());
    const auto first = noise.first_message(octets(question));
    if (!first) continue;
    const auto second = noise.second_message(own_.identity, random_, own_badge(own_));
    if (!second) return {};
    return LinkKeys{
        .cipher = std::make_unique<LinkCipher>(second->keys.responder, second->keys.initiator, now),
        .remote = first->remote,
        .badge = copy(first->payload),
        .message = copy(second->message)};
  }
  return {};
}

std::string TcpSecurity::judge(PeerId peer, const Key& remote, std::span<const std::byte> badge,
                               Member& member) const {
  const auto read = decode_badge(badge);
  if (!read) return "not a key exchange of this protocol";
  const auto answer = own_.judge(peer, remote, *read, session_);
  member = answer.member;
  return answer.verdict == Verdict::Welcome ? "" : describe(answer.verdict);
}

std::string TcpSecurity::expelled(const Member& member) const {
  if (own_.stands(member)) return {};
  return describe(own_.is_revoked(member.key) ? Verdict::Revoked : Verdict::Expired);
}

Credentials::Changed TcpSecurity::change_group(std::span<const std::byte> signed_change) {
  using Changed = Credentials::Changed;
  const Changed changed = own_.change(signed_change, session_);
  // Without an organiser no signature can be checked.
  return changed == Changed::Forged && !own_.organiser ? Changed::Known : changed;
}

}  // namespace tandem::net
