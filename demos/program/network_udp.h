// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "program/network.h"
#include "tandem/net/udp.h"

namespace tandem::demos {

/// Identity, admitted members and connection options.
/// @throws as make_network
net::UdpOptions udp_options(const DemoOptions& options, std::uint64_t scene_hash);

}  // namespace tandem::demos
