// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "acquaintances.h"
#include "tandem/net/udp.h"
#include "udp_peers.h"

namespace tandem::net {

/// Datagrams forwarded by a third peer: our own by others, and others' by us. Times in ns.
class UdpRelay {
 public:
  using PeerId = consensus::PeerId;

  /// @param send  sends to an address that is not relayed
  UdpRelay(const UdpNodeOptions& options, UdpPeers& peers, SendDatagram send)
      : options_(options), peers_(peers), send_(std::move(send)) {}

  /// Directly, or through a third peer if the address is relayed.
  void send(std::span<const std::byte> datagram, const Address& to, std::int64_t now);
  /// The peer that forwards packets to `peer`; 0: direct, or not connected.
  PeerId relay_of(PeerId peer) const;

  /// A datagram delivered by the other end of `from`: forwarded if it is for a third peer. True if
  /// it is for us, as if it had come from relayed_address(relayed.peer).
  [[nodiscard]] bool take(UdpPeers::Connection& from, const UdpConnection::Relayed& relayed,
                          std::int64_t now);

  /// Which peers are connected to each other.
  Acquaintances& acquaintances() { return acquaintances_; }

  const UdpRelayed& counters() const { return counters_; }

 private:
  PeerId relay_to(PeerId peer) const {
    return acquaintances_.relay(peer, [this](PeerId p) { return peers_.is_attached_directly(p); });
  }

  const UdpNodeOptions& options_;
  UdpPeers& peers_;
  SendDatagram send_;
  Acquaintances acquaintances_;
  UdpRelayed counters_;
};

}  // namespace tandem::net
