// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/net/keys.h"
#include "tandem/pbd/export.h"

namespace tandem::net {

using consensus::Role;

// Who is who in a session. A peer's identity is its X25519 key pair. An organiser's is an Ed25519
// one, of which the secret is 32 bytes as well (make_key()): he need not be connected.
// All but derived_id's bit test throw std::runtime_error in builds without libsodium.

/// For people to compare: 16 hex digits in groups of four.
TANDEM_API std::string fingerprint(const Key& public_key);

/// The id that belongs to a public key: nobody without its secret can have it, whatever else is
/// known of the session. Its highest bit is set, and each id with that bit is such a one.
TANDEM_API consensus::PeerId derived_id(const Key& public_key);
constexpr bool is_derived(consensus::PeerId id) { return id >> 63 != 0; }

/// The key that others check an organiser's signatures with.
TANDEM_API Key organiser_public_key(const Key& organiser);

/// What an organiser says of one member.
struct TANDEM_API Certificate {
  Key member{};  ///< public key
  consensus::PeerId peer = 0;
  Role role = Role::Share;
  std::int64_t expires = 0;   ///< s since 1970, UTC; not good from then on
  std::uint64_t session = 0;  ///< scene hash; 0: any that this organiser has

  friend bool operator==(const Certificate&, const Certificate&) = default;
};

constexpr std::size_t kCertificateBytes = 32 + 8 + 1 + 8 + 8 + 64;
/// Throws std::invalid_argument for peer 0.
TANDEM_API std::vector<std::byte> sign(const Certificate& certificate, const Key& organiser);
/// None where that organiser has not signed these bytes. Whether it has expired is not looked at.
TANDEM_API std::optional<Certificate> read_certificate(std::span<const std::byte> bytes,
                                                       const Key& organiser_public);

/// A new session key, and who is not to have it: what an organiser says to all members at once.
struct TANDEM_API GroupChange {
  std::uint64_t number = 0;   ///< the largest counts; > 0
  std::uint64_t session = 0;  ///< as Certificate::session
  Key session_key{};
  std::vector<Key> revoked = {};  ///< public keys, all of them each time; at most kMaxRevoked
};

constexpr std::size_t kMaxRevoked = 100;
/// Secret, since the key is in it. Throws std::invalid_argument for number 0 or too many keys.
TANDEM_API std::vector<std::byte> sign(const GroupChange& change, const Key& organiser);
TANDEM_API std::optional<GroupChange> read_group_change(std::span<const std::byte> bytes,
                                                        const Key& organiser_public);

}  // namespace tandem::net
