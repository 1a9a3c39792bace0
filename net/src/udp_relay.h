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

/// Datagrams that go through a third peer: our own through others, and those of others through us.
/// Times in ns.
class UdpRelay {
 public:
  using PeerId = consensus::PeerId;

  /// @param send  to an address that is not relayed
  UdpRelay(const UdpNodeOptions& options, UdpPeers& peers, SendDatagram send)
      : options_(options), peers_(peers), send_(std::move(send)) {}

  /// Straight there, or through a third peer where the address is relayed.
  void send(std::span<const std::byte> datagram, const Address& to, std::int64_t now);
  /// Through whom packets to `peer` go; 0: straight there, or nowhere.
  PeerId relay_of(PeerId peer) const;

  /// What the other end of `from` has handed over: passed on where it is for a third peer. True
  /// where it is for us, as if it had come from relayed_address(relayed.peer).
  [[nodiscard]] bool take(UdpPeers::Connection& from, const UdpConnection::Relayed& relayed,
                          std::int64_t now);

  /// Who is connected to whom.
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
