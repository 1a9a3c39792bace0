// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "crypto.h"
#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"
#include "tandem/pbd/types.h"

namespace tandem::nats {

// Messages to cells, before sealing (group_seal.h).

/// Position of a peer, and how far it listens.
struct Presence {
  std::int64_t sent = 0;                   ///< ns, by the sender's own clock: meaningless to others
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world
  double hears = 0.0;                      ///< m: distance within which it connects
};

/// Summary of a cell.
struct Summary {
  Cell cell;
  std::uint32_t people = 0;
  std::span<const std::byte> content;  ///< the application's; a view into the decoded bytes
  /// Ed25519 over everything before it; zeros: unsigned.
  std::array<std::uint8_t, net::crypto::kSignatureBytes> signature{};
};

constexpr std::size_t kMaxContent = 8 * 1024;  ///< bytes of a summary's content
constexpr double kMaxHears = 1e7;              ///< m

void encode(const Presence& presence, std::vector<std::byte>& out);
/// Without the signature's bytes, which follow.
void encode(const Summary& summary, std::vector<std::byte>& out);

/// None: wrong length, a number not finite or out of range, an impossible cell.
std::optional<Presence> decode_presence(std::span<const std::byte> bytes);
std::optional<Summary> decode_summary(std::span<const std::byte> bytes);

}  // namespace tandem::nats
