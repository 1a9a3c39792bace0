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

// What is said to cells, before it is sealed (group_seal.h).

/// Where a peer is, and how far it hears.
struct Presence {
  std::int64_t sent = 0;  ///< ns, of the sender's own clock: nobody else can read it
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world
  double hears = 0.0;                      ///< m: whom it connects to
};

/// What a cell comes to.
struct Summary {
  Cell cell;
  std::uint32_t people = 0;
  std::span<const std::byte> content;  ///< the application's; a view into what was decoded
  /// Ed25519 over all before it; zeros: nobody's.
  std::array<std::uint8_t, net::crypto::kSignatureBytes> signature{};
};

constexpr std::size_t kMaxContent = 8 * 1024;  ///< bytes of a summary's content
constexpr double kMaxHears = 1e7;              ///< m

void encode(const Presence& presence, std::vector<std::byte>& out);
/// Without the signature's bytes, which follow.
void encode(const Summary& summary, std::vector<std::byte>& out);

/// None: wrong length, a number that is not finite or out of range, a cell that cannot be.
std::optional<Presence> decode_presence(std::span<const std::byte> bytes);
std::optional<Summary> decode_summary(std::span<const std::byte> bytes);

}  // namespace tandem::nats
