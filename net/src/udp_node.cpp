// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_node.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tandem::net {

using consensus::PeerId;

namespace {

constexpr std::int64_t kMeshPeriod = 250'000'000;       // ns, interval of looking for relays
constexpr std::int64_t kRelayPatience = 2'000'000'000;  // ns

}  // namespace

UdpNode::UdpNode(const UdpNodeOptions& options, const crypto::Random& random, SendDatagram send)
    : options_(options),
      random_(random),
      clock_(options.handshake.self, options.clock == Clock::Session, options.start,
             options.correction),
      peers_(options_,
             [this](PeerId peer) {
               relay_.acquaintances().restart(peer, now_);
               clock_.lost(peer);
             }),
      relay_(options_, peers_, std::move(send)),
      transmit_([this](std::span<const std::byte> datagram, const Address& to) {
        relay_.send(datagram, to, now_);
      }),
      dials_(options_, random_, peers_,
             {.next_receiver = [this] { return free_receiver(); },
              .send = transmit_,
              .established =
                  [this](const Session& session, const Address& address) {
                    peers_.add(session, address, true, now_);
                  }}),
      responder_(
          options_.handshake, random,
          [this](const Introduction& other, const Member& member, const Address& from) {
            return peers_.decide(other, member, from, now_);
          },
          [this] { return free_receiver(); }) {
  options_.handshake.complete(options_.handshake.self);
  std::array<std::uint8_t, 2> bytes{};
  random_(bytes);
  receiver_prefix_ = static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

void UdpNode::hang_up(std::uint64_t path, const std::string& reason, std::int64_t now) {
  now_ = now;
  const Address address = path_address(path);
  dials_.remove(address);
  for (auto& [receiver, connection] : peers_.connections()) {
    if (connection.path.address() != address) continue;
    connection.link->leave(reason, now);
    peers_.detach(connection);
  }
}

bool UdpNode::on_datagram(std::span<const std::byte> datagram, const Address& from,
                          std::int64_t now) {
  now_ = now;
  if (from.port == 0) {  // no datagram comes from port 0
    ++unknown_;
    return false;
  }
  return receive(datagram, from, now);
}

bool UdpNode::receive(std::span<const std::byte> datagram, const Address& from, std::int64_t now) {
  if (const auto header = decode_protected_header(datagram)) {
    return on_packet(*header, datagram, from, now);
  }
  const auto packet = decode_handshake(datagram);
  if (packet &&
      (packet->type == HandshakeType::Challenge || packet->type == HandshakeType::Accept)) {
    dials_.on_datagram(datagram, from, now);
    return true;
  }
  const auto result = responder_.on_datagram(datagram, from, now);
  if (!result.reply.empty()) transmit_(result.reply, from);
  if (result.session) peers_.add(*result.session, from, false, now);
  return !result.reply.empty();
}

bool UdpNode::on_packet(const ProtectedHeader& header, std::span<const std::byte> datagram,
                        const Address& from, std::int64_t now) {
  const auto at = peers_.connections().find(header.receiver);
  // A relayed datagram is not relayed further.
  if (at == peers_.connections().end() || !at->second.path.may_be_at(from) ||
      (header.relay && is_relayed(from))) {
    ++unknown_;
    return false;
  }
  Connection& connection = at->second;
  UdpConnection& link = *connection.link;
  const bool elsewhere = !connection.path.is_at(from);
  // Also for a copy received before, which is not opened.
  if (!elsewhere) connection.path.refute(header.sequence);
  const bool first = !link.confirmed();
  if (!link.open(datagram, now)) {
    if (!connection.path.is_known(from)) ++unknown_;
    return false;
  }
  if (first) attach(connection, now);
  if (elsewhere) {
    connection.path.on_elsewhere(from, header.sequence, datagram.size(), random_, now);
  }
  link.read(now);
  connection.path.on_read(from, transmit_, now);
  if (connection.record == nullptr) return true;
  consensus::PeerStatus& status = connection.record->status;
  ++status.packets_in;
  status.bytes_in += datagram.size();
  const auto exchange = link.channels().take_exchange();
  if (exchange && options_.clock != Clock::None) {
    const ClockSample& times = exchange->sample;
    connection.round_trip = times.received - times.sent - (times.their_sent - times.their_received);
    clock_.on_exchange(status.id, times, exchange->claim);
  }
  const PeerId peer = status.id;
  ChannelInbox& inbox = link.channels().inbox();
  for (const KnownPeer& known : inbox.take_told()) told(peer, known, now);
  const auto change = inbox.take_group_change();
  // Verified by everybody, so that nobody forwards an unsigned change.
  if (!change.empty() && change_group(change, now) == Credentials::Changed::Forged &&
      options_.handshake.organiser) {
    link.leave("dropped: group change that the organiser has not signed", now);
  }
  const auto relayed = link.take_relayed();
  if (link.state() != UdpConnection::State::Open) {
    peers_.detach(connection);
  } else if (relayed) {
    passed_on(peer, *relayed, now);
  }
  return true;
}

std::uint32_t UdpNode::free_receiver() {
  for (;;) {
    std::array<std::uint8_t, 2> bytes{};
    random_(bytes);
    const std::uint32_t out = std::uint32_t{receiver_prefix_} << 16 | bytes[0] << 8 | bytes[1];
    if (out != 0 && !dials_.has_promised(out) && !peers_.connections().contains(out)) return out;
  }
}

void UdpNode::attach(Connection& connection, std::int64_t now) {
  if (!peers_.attach(connection, now)) return;
  const PeerId peer = connection.record->status.id;
  dials_.on_attached(peer, connection.path.address());
  relay_.acquaintances().restart(peer, now);
  const auto& change = options_.handshake.group_change;
  if (!change.empty()) connection.link->channels().post_group_change(change);
  connection.tell_due = now;
  if (!is_relayed(connection.path.address())) peers_.tell_others(connection);
}

void UdpNode::poll(std::int64_t now) {
  now_ = now;
  if (options_.clock != Clock::None && now >= clock_due_) {
    clock_.update(now);
    clock_due_ = now + ClockSync::kUpdate;
  }
  if (now >= mesh_due_) {
    relay_.acquaintances().expire(now);
    if (options_.relay && !peers_.is_leaving()) {
      for (const PeerId peer : relay_.acquaintances().waiting(kRelayPatience, now)) {
        dials_.add_relayed(peer, now);
      }
    }
    dials_.forget_told(now);
    peers_.expel(now);
    mesh_due_ = now + kMeshPeriod;
  }
  const ClockClaim claim = clock_.claim(now);
  const ClockClaim* told = options_.clock == Clock::None ? nullptr : &claim;
  dials_.poll(now);
  auto& connections = peers_.connections();
  for (auto at = connections.begin(); at != connections.end();) {
    Connection& connection = at->second;
    peers_.introduce(connection, now);
    if (connection.path.poll(transmit_, random_, now)) {
      // Announcements of other peers may have gone to the old address.
      connection.told_to = 0;
      connection.tell_due = now;
      ++moves_;
      if (connection.record != nullptr) peers_.tell_others(connection);
    }
    for (auto out = connection.link->poll(now, told); !out.empty();
         out = connection.link->poll(now, told)) {
      connection.path.send(out, transmit_);
      if (connection.record == nullptr) continue;
      ++connection.record->status.packets_out;
      connection.record->status.bytes_out += out.size();
    }
    if (connection.link->state() != UdpConnection::State::Open) peers_.detach(connection);
    at = connection.link->state() == UdpConnection::State::Closed ? connections.erase(at)
                                                                  : std::next(at);
  }
}

std::int64_t UdpNode::next_due(std::int64_t now) {
  std::int64_t due = dials_.next_due(now);
  for (const auto& [receiver, connection] : peers_.connections()) {
    due = std::min({due, connection.link->next_due(now), connection.path.next_due(now)});
    if (connection.record != nullptr && options_.introduces) {
      due = std::min(due, std::max(now, connection.tell_due));
    }
  }
  return due;
}

void UdpNode::leave(const std::string& reason, std::int64_t now) {
  now_ = now;
  peers_.leave(reason, now);
}

void UdpNode::drop(PeerId peer, const std::string& reason, std::int64_t now) {
  now_ = now;
  peers_.drop(peer, reason, now);
}

std::size_t UdpNode::max_state_bytes() const {
  std::size_t out = SIZE_MAX;
  for (const auto& [receiver, connection] : peers_.connections()) {
    if (connection.record == nullptr) continue;
    out = std::min(out, connection.link->channels().mtu().size());
  }
  if (out == SIZE_MAX) out = std::min(MtuSearch::kBase, options_.connection.max_datagram);
  return out - kProtectedOverhead - kChannelHeader - kStateHeader;
}

Credentials::Changed UdpNode::change_group(std::span<const std::byte> signed_change,
                                           std::int64_t now) {
  now_ = now;
  HandshakeConfig& own = options_.handshake;
  const auto changed = own.change(signed_change, own.scene_hash);
  if (changed != Credentials::Changed::Yes) return changed;
  peers_.expel(now);
  for (auto& [receiver, connection] : peers_.connections()) {
    if (connection.record != nullptr) {
      connection.link->channels().post_group_change(own.group_change);
    }
  }
  dials_.on_group_change();
  return changed;
}

void UdpNode::told(PeerId teller, const KnownPeer& known, std::int64_t now) {
  Connection* const connection = peers_.attached(teller);
  if (connection == nullptr) return;
  if (known.peer == teller) {
    DirectWay* const direct = connection->path.direct();
    if (direct != nullptr) direct->offer(known.address);
    return;
  }
  if (!options_.introduces || known.peer == 0 || known.peer == options_.handshake.self) {
    return;
  }
  if (!is_relayed(connection->path.address())) {
    relay_.acquaintances().note(known.peer, teller, now);
  }
  if (!is_host(known.address)) return;
  if (Connection* there = peers_.attached(known.peer)) there->path.on_rumour(known.address, now);
  dials_.add_told(known, teller, now);
}

void UdpNode::passed_on(PeerId relay, const UdpConnection::Relayed& relayed, std::int64_t now) {
  now_ = now;
  Connection* connection = peers_.attached(relay);
  if (connection == nullptr || !relay_.take(*connection, relayed, now)) return;
  (void)receive(relayed.datagram, relayed_address(relayed.peer), now);
}

ClockStatus UdpNode::clock(std::int64_t now) {
  ClockStatus out = clock_.status(now);
  if (options_.clock == Clock::None) out.error_bound = -1;
  return out;
}

}  // namespace tandem::net
