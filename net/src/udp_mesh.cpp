// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// How members of a mesh find each other: addresses of third peers, and relays for those that have
// no route.
#include <algorithm>

#include "udp_node.h"

namespace tandem::net {

using consensus::PeerId;

namespace {

constexpr std::int64_t kTellPeriod = 2'000'000'000;     // ns
constexpr std::size_t kTellAtOnce = 4;                  // peers in a turn
constexpr std::int64_t kRelayPatience = 2'000'000'000;  // ns
constexpr std::int64_t kToldLife = 30'000'000'000;      // ns, of an address after it was told last
constexpr std::size_t kMaxTold = 64;                    // dials
constexpr std::ptrdiff_t kMaxToldBy = 16;               // by one member
constexpr std::ptrdiff_t kMaxToldOf = 4;                // addresses of one peer

/// A path is ours alone. Whoever hears of no address knows whom to ask for him all the same.
Address told_address(const Address& address) { return is_path(address) ? Address{} : address; }

}  // namespace

void UdpNode::transmit(std::span<const std::byte> datagram, const Address& to) {
  if (!is_relayed(to)) {
    send_(datagram, to);
    return;
  }
  const PeerId target = relayed_peer(to);
  Connection* relay = attached(
      acquaintances_.relay(target, [this](PeerId peer) { return is_attached_directly(peer); }));
  if (relay == nullptr) return;
  const auto sealed =
      relay->link->seal({.forward = true, .peer = target, .datagram = datagram}, now_);
  if (!sealed.empty()) send_(sealed, relay->address);
}

bool UdpNode::is_attached_directly(PeerId peer) const {
  const auto record = records_.find(peer);
  return record != records_.end() && record->second.receiver != 0 &&
         !is_relayed(connections_.at(record->second.receiver).address);
}

PeerId UdpNode::relay_of(PeerId peer) const {
  const auto record = records_.find(peer);
  if (record == records_.end() || record->second.receiver == 0 || is_attached_directly(peer)) {
    return 0;
  }
  return acquaintances_.relay(peer, [this](PeerId p) { return is_attached_directly(p); });
}

void UdpNode::on_told(Connection& connection, const KnownPeer& known, std::int64_t now) {
  if (!options_.introduces) return;
  const PeerId teller = connection.link->session().remote.peer;
  if (known.peer == 0 || known.peer == options_.handshake.self || known.peer == teller) return;
  if (!is_relayed(connection.address)) acquaintances_.note(known.peer, teller, now);
  if (!is_host(known.address)) return;
  if (Connection* there = attached(known.peer)) note_rumour(*there, known.address, now);
  for (Dial& dial : dials_) {
    if (dial.address != known.address) continue;
    dial.told_at = now;
    return;
  }
  const auto told_by = std::ranges::count_if(dials_, [&](const Dial& dial) {
    return dial.told_by == teller && !is_attached_directly(dial.peer);
  });
  const auto told_of = std::ranges::count(dials_, known.peer, &Dial::peer);
  if (is_attached_directly(known.peer) || told_by >= kMaxToldBy || told_of >= kMaxToldOf ||
      dials_.size() >= options_.max_peers + kMaxTold) {
    return;
  }
  dials_.push_back({.address = known.address,
                    .peer = known.peer,
                    .due = now,
                    .backoff = options_.backoff_min,
                    .told_by = teller,
                    .told_at = now});
}

void UdpNode::on_relayed(Connection& connection, const UdpConnection::Relayed& relayed,
                         std::int64_t now) {
  const PeerId sender = connection.link->session().remote.peer;
  if (!options_.relay || is_relayed(connection.address)) {
    ++relayed_.refused;
    return;
  }
  if (!relayed.forward) {
    if (relayed.peer == 0 || relayed.peer == options_.handshake.self || relayed.peer == sender) {
      ++relayed_.refused;
      return;
    }
    acquaintances_.note(relayed.peer, sender, now);
    receive(relayed.datagram, relayed_address(relayed.peer), now);
    return;
  }
  Connection* target = is_attached_directly(relayed.peer) ? attached(relayed.peer) : nullptr;
  if (target == nullptr || target == &connection || !connection.relay.ready(now)) {
    ++relayed_.refused;
    return;
  }
  connection.relay.spend(relayed.datagram.size());
  const auto sealed =
      target->link->seal({.forward = false, .peer = sender, .datagram = relayed.datagram}, now);
  if (sealed.empty()) return;
  send_(sealed, target->address);
  ++relayed_.forwarded;
}

void UdpNode::tell_others(const Connection& connection) {
  if (!options_.introduces) return;
  const PeerId peer = connection.link->session().remote.peer;
  for (auto& [number, other] : connections_) {
    if (other.attached && &other != &connection) {
      other.link->tell({.peer = peer, .address = told_address(connection.address)});
    }
  }
}

void UdpNode::introduce(Connection& connection, std::int64_t now) {
  if (!options_.introduces || !connection.attached || now < connection.tell_due) return;
  const PeerId other = connection.link->session().remote.peer;
  // The next ones in the order of their ids, after whom it was told of last.
  std::size_t told = 0;
  auto at = records_.upper_bound(connection.told_to);
  for (; at != records_.end() && told < kTellAtOnce; ++at) {
    if (at->first == other || !is_attached_directly(at->first)) continue;
    connection.link->tell(
        {.peer = at->first, .address = told_address(connections_.at(at->second.receiver).address)});
    connection.told_to = at->first;
    ++told;
  }
  const bool round = at == records_.end();
  if (round) connection.told_to = 0;
  connection.tell_due = now + (round ? kTellPeriod : kTellPeriod / 10);
}

void UdpNode::look_for_relays(std::int64_t now) {
  acquaintances_.expire(now);
  if (!options_.relay || leaving_) return;
  for (const PeerId peer : acquaintances_.waiting(kRelayPatience, now)) {
    const auto record = records_.find(peer);
    if (record != records_.end() && (record->second.receiver != 0 || record->second.dropped)) {
      continue;
    }
    const Address address = relayed_address(peer);
    if (std::ranges::find(dials_, address, &Dial::address) != dials_.end()) continue;
    dials_.push_back({.address = address,
                      .peer = peer,
                      .due = now,
                      .backoff = options_.backoff_min,
                      .told_by = options_.handshake.self,
                      .told_at = now});
  }
}

void UdpNode::forget_dials(std::int64_t now) {
  std::erase_if(dials_, [&](const Dial& dial) {
    return dial.told_by != 0 && !dial.attempt && now - dial.told_at > kToldLife;
  });
}

}  // namespace tandem::net
