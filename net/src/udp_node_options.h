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

/// Of a UdpNode. Times in ns.
struct UdpNodeOptions {
  HandshakeConfig handshake;
  UdpConnectionOptions connection;
  std::size_t max_peers = 64;
  /// Of whom who has gone is remembered, at most; and with those who are there 2 * max_peers.
  std::size_t max_departed = SIZE_MAX;
  std::int64_t backoff_min = 100'000'000;
  std::int64_t backoff_max = 3'000'000'000;
  std::int64_t drop_hold = 1'000'000'000;
  bool relay = true;  ///< for others, and by others
  /// Members tell each other of third ones and dial whom they are told of; false: whoever drives
  /// the node says whom to meet.
  bool introduces = true;
  double relay_kbit = 256.0;  ///< from each peer, for others
  Clock clock = Clock::Session;
  /// DatagramPath::max_datagram() of the path with this number; empty: what fits into another one.
  std::function<std::size_t(std::uint64_t path)> path_limit;
  /// Where this node is reached without a path. The peers of prefer_direct() are told, and spoken
  /// to from socket to socket where that works. Such a node is polled every few ms.
  std::vector<Address> direct_addresses;
  std::int64_t start = 0;       // the time at construction
  std::int64_t correction = 0;  // session time minus that, to begin with
};

}  // namespace tandem::net
