// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_relay.h"

namespace tandem::net {

void UdpRelay::send(std::span<const std::byte> datagram, const Address& to, std::int64_t now) {
  if (!is_relayed(to)) {
    send_(datagram, to);
    return;
  }
  const PeerId target = relayed_peer(to);
  UdpPeers::Connection* relay = peers_.attached(relay_to(target));
  if (relay == nullptr) return;
  const auto sealed =
      relay->link->seal({.forward = true, .peer = target, .datagram = datagram}, now);
  if (!sealed.empty()) send_(sealed, relay->path.address());
}

consensus::PeerId UdpRelay::relay_of(PeerId peer) const {
  if (peers_.attached(peer) == nullptr || peers_.is_attached_directly(peer)) return 0;
  return relay_to(peer);
}

bool UdpRelay::take(UdpPeers::Connection& from, const UdpConnection::Relayed& relayed,
                    std::int64_t now) {
  const PeerId sender = from.link->session().remote.peer;
  if (!options_.relay || is_relayed(from.path.address())) {
    ++counters_.refused;
    return false;
  }
  if (!relayed.forward) {
    if (relayed.peer == 0 || relayed.peer == options_.handshake.self || relayed.peer == sender) {
      ++counters_.refused;
      return false;
    }
    acquaintances_.note(relayed.peer, sender, now);
    return true;
  }
  UdpPeers::Connection* target =
      peers_.is_attached_directly(relayed.peer) ? peers_.attached(relayed.peer) : nullptr;
  if (target == nullptr || target == &from || !from.relay.ready(now)) {
    ++counters_.refused;
    return false;
  }
  from.relay.spend(relayed.datagram.size());
  const auto sealed =
      target->link->seal({.forward = false, .peer = sender, .datagram = relayed.datagram}, now);
  if (sealed.empty()) return false;
  send_(sealed, target->path.address());
  ++counters_.forwarded;
  return false;
}

}  // namespace tandem::net
