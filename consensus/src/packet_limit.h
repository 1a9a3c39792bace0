// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>

#include "tandem/consensus/transport.h"

namespace tandem::consensus {

/// Bytes of the longest packet that decode() reads and the transport takes. It may change from one
/// step to the next, as ways and their limits do.
inline std::size_t packet_limit(const Transport& transport, Delivery delivery) {
  return std::min(kMaxPacketBytes, transport.max_packet_bytes(delivery));
}

}  // namespace tandem::consensus
