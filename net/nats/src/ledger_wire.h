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

// A record as the server keeps it, sealed under the session key and bound to its body's id:
//   u8 version, 16 bytes of salt, sealed: i32 x, i32 y of the cell, u64 keeper, pose, twist,
//   u64 token, u64 revision; 16 bytes of tag. Each has a key of its own, made of the session key
//   and its salt.

/// Tells one writing from another.
using Token = std::uint64_t;

/// Of two records of a body the later one counts, whatever the server says. Two of the same
/// revision come about where a server has lost one and who wrote the other had not heard of it:
/// then chance decides, for everybody alike.
struct Version {
  std::uint64_t revision = 0;
  Token token = 0;
  auto operator<=>(const Version&) const = default;
};

/// Where a record stands on a server. A server that has lost records gives their sequences again.
struct Place {
  std::uint64_t life = 0;      ///< of a server, from its start to its end; 0: not known
  std::uint64_t sequence = 0;  ///< in its stream; 0: no record
};

struct StoredRecord {
  LedgerRecord record;
  Token token = 0;
  Place place;  ///< no part of what is sealed
  Version version() const { return {record.revision, token}; }
};

void seal_record(const LedgerRecord& record, Token token, const net::crypto::Secret& session_key,
                 const net::crypto::Random& random, std::vector<std::byte>& out);

/// None: malformed, forged, another body's, or with a number that cannot be.
std::optional<StoredRecord> open_record(std::span<const std::byte> bytes,
                                        const consensus::SharedId& id,
                                        const net::crypto::Secret& session_key);

}  // namespace tandem::nats
