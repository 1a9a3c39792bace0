// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/net/udp.h"
#include "udp_node.h"

namespace tandem::net {

/// Who a node is, whom it lets in and how its connections go. What is about sockets is left out.
/// @throws std::invalid_argument (UdpOptions::validate)
UdpNodeOptions node_options(const UdpOptions& options);

}  // namespace tandem::net
