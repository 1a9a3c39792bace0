// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

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

/// Tells one writing from another, where an answer was lost.
using Token = std::uint64_t;

void seal_record(const LedgerRecord& record, Token token, const net::crypto::Secret& session_key,
                 const net::crypto::Random& random, std::vector<std::byte>& out);

struct OpenedRecord {
  LedgerRecord record;  ///< the revision as it was sealed: the server's number says more
  Token token = 0;
};
/// None: malformed, forged, another body's, or with a number that cannot be.
std::optional<OpenedRecord> open_record(std::span<const std::byte> bytes,
                                        const consensus::SharedId& id,
                                        const net::crypto::Secret& session_key);

}  // namespace tandem::nats
