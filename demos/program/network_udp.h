// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "program/network.h"
#include "tandem/net/udp.h"

namespace tandem::demos {

/// Who this peer is, whom it lets in, and how its connections go.
/// @throws as make_network
net::UdpOptions udp_options(const DemoOptions& options, std::uint64_t scene_hash);

}  // namespace tandem::demos
