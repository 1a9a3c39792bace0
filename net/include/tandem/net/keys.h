// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::net {

/// 32 bytes: a session key, or an X25519 key of a peer.
using Key = std::array<std::uint8_t, 32>;

struct TANDEM_API TrustedPeer {
  consensus::PeerId peer = 0;
  Key public_key{};
};

// Both throw std::runtime_error in builds without libsodium.

/// From the system's generator.
TANDEM_API Key make_key();
/// The public key to give to others, of a TcpOptions::identity or UdpOptions::identity.
TANDEM_API Key public_key(const Key& identity);

}  // namespace tandem::net
