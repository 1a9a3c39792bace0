// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "crypto.h"
#include "tandem/nats/body_ledger.h"

namespace tandem::nats {

// A record on the server, sealed under the session key and bound to its body's id:
//   u8 version, 16 bytes of salt, sealed: i32 x, i32 y of the cell, u64 keeper, pose, twist,
//   u64 token, u64 revision; 16 bytes of tag. Each has its own key, derived from the session key
//   and its salt.

/// Distinguishes writes.
using Token = std::uint64_t;

/// The later of two records of a body counts, whatever the server says. Two can have one revision
/// if a server has lost one and the writer of the other did not know it: then the random token
/// decides, for all alike.
struct Version {
  std::uint64_t revision = 0;
  Token token = 0;
  auto operator<=>(const Version&) const = default;
};

/// Position of a record on a server. A server that has lost records reuses their sequences.
struct Place {
  std::uint64_t life = 0;      ///< of a server, from its start to its end; 0 = unknown
  std::uint64_t sequence = 0;  ///< in its stream; 0 = no record
};

struct StoredRecord {
  LedgerRecord record;
  Token token = 0;
  Place place;  ///< not sealed
  Version version() const { return {record.revision, token}; }
};

void seal_record(const LedgerRecord& record, Token token, const net::crypto::Secret& session_key,
                 const net::crypto::Random& random, std::vector<std::byte>& out);

/// None: malformed, forged, another body's, or with an impossible number.
std::optional<StoredRecord> open_record(std::span<const std::byte> bytes,
                                        const consensus::SharedId& id,
                                        const net::crypto::Secret& session_key);

}  // namespace tandem::nats
