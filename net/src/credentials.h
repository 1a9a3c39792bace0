// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "crypto.h"
#include "handshake_wire.h"

namespace tandem::net {

/// A member as seen by a transport.
struct Member {
  crypto::PublicKey key{};
  Role role = Role::Share;
  /// The id belongs to this key alone: listed, signed by the organiser, or derived from the key.
  /// Any other id is kept by its present user while present.
  bool bound = false;
  std::int64_t expires = INT64_MAX;  // s since 1970
};

/// Who this process is, which peers it admits, and in which role. With listed public keys or an
/// organiser, those listed or with a certificate; otherwise any peer that has the session key and
/// has done the work for its id.
///
/// A made-up id costs its maker 2^kWorkBits hashes, several times the curve arithmetic of a
/// handshake; checking it costs one.
struct Credentials {
  static constexpr int kWorkBits = 14;
  static constexpr std::size_t kFormerKeys = 3;

  crypto::Secret session_key;
  crypto::KeyPair identity;
  std::map<consensus::PeerId, crypto::PublicKey> trusted;
  std::optional<Key> organiser;         // public
  std::vector<std::byte> certificate;   // our own; empty: none
  std::uint64_t stamp = 0;              // work for our own id
  std::function<std::int64_t()> today;  // s since 1970; null: the system clock

  /// State set by the organiser's messages, see GroupChange.
  std::uint64_t group = 0;              // its number
  std::vector<std::byte> group_change;  // signed
  std::vector<crypto::Secret> former;   // former session keys, the latest first
  std::vector<crypto::PublicKey> revoked;

  /// Do the work for an id, if it is missing.
  void complete(consensus::PeerId self);
  /// What to send beside the id.
  Badge badge() const;

  struct Answer {
    Verdict verdict = Verdict::Welcome;
    Member member;
  };
  Answer judge(consensus::PeerId peer, const crypto::PublicKey& key, const Badge& badge,
               std::uint64_t session) const;
  bool is_revoked(const crypto::PublicKey& public_key) const;
  /// Whether a member still is one.
  bool stands(const Member& member) const;

  std::size_t key_count() const { return 1 + former.size(); }
  /// 0: the key in force; then former ones, with which members come back.
  const crypto::Secret& key(std::size_t index) const {
    return index == 0 ? session_key : former[index - 1];
  }

  enum class Changed {
    Yes,
    Known,   // this change or a later one is in force
    Forged,  // or without an organiser, or of another session
  };
  Changed change(std::span<const std::byte> signed_change, std::uint64_t session);

  std::int64_t now() const;
};

/// From the options that TcpOptions and UdpOptions share.
template <class Options>
Credentials credentials_of(const Options& options, const Key& session_key) {
  Credentials out{.session_key = crypto::Secret(session_key),
                  .identity = crypto::make_key_pair(crypto::system_random()),
                  .organiser = options.organiser,
                  .certificate = options.certificate};
  if (options.identity) {
    out.identity.secret = crypto::Secret(*options.identity);
    out.identity.public_key = crypto::public_key_of(out.identity.secret);
  }
  for (const TrustedPeer& each : options.trusted) out.trusted[each.peer] = each.public_key;
  return out;
}

/// Number for which the hash of id and key has kWorkBits zero bits.
std::uint64_t work_for(consensus::PeerId peer, const crypto::PublicKey& key);
bool has_worked(consensus::PeerId peer, const crypto::PublicKey& key, std::uint64_t stamp);

}  // namespace tandem::net
