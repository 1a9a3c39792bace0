// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "address.h"
#include "direct_way.h"
#include "handshake.h"
#include "tandem/net/clock.h"
#include "udp_connection.h"

namespace tandem::net {

/// Options of a UdpNode. Times in ns.
struct UdpNodeOptions {
  HandshakeConfig handshake;
  UdpConnectionOptions connection;
  std::size_t max_peers = 64;
  /// Peers that have left and are remembered, at most; those present included, 2 * max_peers.
  std::size_t max_departed = SIZE_MAX;
  std::int64_t backoff_min = 100'000'000;
  std::int64_t backoff_max = 3'000'000'000;
  std::int64_t drop_hold = 1'000'000'000;
  bool relay = true;  ///< relay for others, and be relayed
  /// Whether members announce third peers and dial the announced ones; false: the owner of the node
  /// dials.
  bool introduces = true;
  double relay_kbit = 256.0;  ///< budget of each peer for relaying
  Clock clock = Clock::Session;
  /// DatagramPath::max_datagram() of the path with this number; empty: the size for a relayed
  /// datagram.
  std::function<std::size_t(std::uint64_t path)> path_limit;
  /// Addresses of this node without a path. They are announced to the peers of prefer_direct(),
  /// which are then addressed from socket to socket if that works. Such a node is polled every few
  /// ms.
  std::vector<Address> direct_addresses;
  std::int64_t start = 0;       // the time at construction
  std::int64_t correction = 0;  // initial session time minus that
};

}  // namespace tandem::net
