// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/net/udp.h"
#include "udp_node.h"

namespace tandem::net {

/// Identity, admission and connection options of a node; those of sockets are left out.
/// @throws std::invalid_argument (UdpOptions::validate)
UdpNodeOptions node_options(const UdpOptions& options);

}  // namespace tandem::net
