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

// Identities in a session. A peer's identity is an X25519 key pair. An organiser's is an Ed25519
// key pair, whose secret also has 32 bytes (make_key()); the organiser need not be connected. All
// but is_derived() throw std::runtime_error in builds without libsodium.

/// For people to compare: 16 hex digits in groups of four.
TANDEM_API std::string fingerprint(const Key& public_key);

/// The peer id of a public key: only the owner of its secret can use it. The highest bit is set in
/// these ids, and in no others.
TANDEM_API consensus::PeerId derived_id(const Key& public_key);
constexpr bool is_derived(consensus::PeerId id) { return id >> 63 != 0; }

/// The key that verifies an organiser's signatures.
TANDEM_API Key organiser_public_key(const Key& organiser);

/// An organiser's statement about one member.
struct TANDEM_API Certificate {
  Key member{};  ///< public key
  consensus::PeerId peer = 0;
  Role role = Role::Share;
  std::int64_t expires = 0;   ///< s since 1970, UTC; invalid from then on
  std::uint64_t session = 0;  ///< scene hash; 0 = any session of this organiser

  friend bool operator==(const Certificate&, const Certificate&) = default;
};

constexpr std::size_t kCertificateBytes = 32 + 8 + 1 + 8 + 8 + 64;
/// Throws std::invalid_argument for peer 0.
TANDEM_API std::vector<std::byte> sign(const Certificate& certificate, const Key& organiser);
/// None if this organiser has not signed these bytes. Expiry is not checked.
TANDEM_API std::optional<Certificate> read_certificate(std::span<const std::byte> bytes,
                                                       const Key& organiser_public);

/// A new session key and the revoked members: an organiser's message to all members.
struct TANDEM_API GroupChange {
  std::uint64_t number = 0;   ///< the largest one holds; > 0
  std::uint64_t session = 0;  ///< as Certificate::session
  Key session_key{};
  std::vector<Key> revoked = {};  ///< public keys, complete each time; at most kMaxRevoked
};

constexpr std::size_t kMaxRevoked = 100;
/// The result is secret, as it contains the key. Throws std::invalid_argument for number 0 or too
/// many keys.
TANDEM_API std::vector<std::byte> sign(const GroupChange& change, const Key& organiser);
TANDEM_API std::optional<GroupChange> read_group_change(std::span<const std::byte> bytes,
                                                        const Key& organiser_public);

}  // namespace tandem::net
