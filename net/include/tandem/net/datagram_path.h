// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "tandem/pbd/export.h"

namespace tandem::net {

/// A way to one peer for whole datagrams, of at most 1300 bytes or max_datagram(), that is no
/// address of UdpTransport's socket: what ICE has found (tandem::ice), a tunnel, a test. It may
/// lose, reorder and repeat, and it is trusted with nothing: what goes over it is sealed.
class TANDEM_API DatagramPath {
 public:
  using Receive = std::function<void(std::span<const std::byte> datagram)>;

  virtual ~DatagramPath() = default;
  /// Never waits and throws nothing: what cannot be sent now is lost. One call at a time, on any
  /// thread.
  virtual void send(std::span<const std::byte> datagram) = 0;
  /// From now on what comes is given to `receive`, on any thread, one at a time; it never waits. An
  /// empty one: to nobody, and after this returns no call of the one before is running.
  virtual void receive(Receive receive) = 0;
  /// Bytes of a datagram up to which it is worth searching for what the way carries, asked for each
  /// connection once, on any thread: more than the 1200 to begin with only where nothing cuts
  /// datagrams into pieces on the way.
  virtual std::size_t max_datagram() const { return 1200; }
};

}  // namespace tandem::net
