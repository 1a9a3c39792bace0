// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "tandem/pbd/export.h"

namespace tandem::net {

/// A path to one peer for whole datagrams, of at most 1300 bytes or max_datagram(), other than an
/// address of UdpTransport's socket: found by ICE (tandem::ice), a tunnel, a test. It may lose,
/// reorder and repeat. It is not trusted: all datagrams are sealed.
class TANDEM_API DatagramPath {
 public:
  using Receive = std::function<void(std::span<const std::byte> datagram)>;

  virtual ~DatagramPath() = default;
  /// Never blocks or throws: a datagram that cannot be sent now is lost. One call at a time, on any
  /// thread.
  virtual void send(std::span<const std::byte> datagram) = 0;
  /// From now on datagrams received are given to `receive`, on any thread, one at a time; it never
  /// blocks. An empty function stops that: once this returns, no call of the one before is running.
  virtual void receive(Receive receive) = 0;
  /// Longest datagram for which a path MTU search is worthwhile, bytes, queried once for each
  /// connection, on any thread. More than the initial 1200 only if no datagram is fragmented on the
  /// path.
  virtual std::size_t max_datagram() const { return 1200; }
};

}  // namespace tandem::net
