// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_node.h"

#include <algorithm>
#include <utility>

namespace tandem::net {

using consensus::PeerId;

namespace {

constexpr std::int64_t kMeshPeriod = 250'000'000;  // ns, between two looks for relays

}  // namespace

UdpNode::UdpNode(const UdpNodeOptions& options, const crypto::Random& random, Send send)
    : options_(options),
      random_(random),
      send_(std::move(send)),
      clock_(options.handshake.self, options.clock == Clock::Session, options.start,
             options.correction),
      responder_(
          options_.handshake, random,
          [this](const Introduction& other, const Member& member, const Address& from) {
            return decide(other, member, from, now_);
          },
          [this] { return free_receiver(); }) {
  options_.handshake.complete(options_.handshake.self);
  std::array<std::uint8_t, 2> bytes{};
  random_(bytes);
  receiver_prefix_ = static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

void UdpNode::dial(const Address& address, std::int64_t now) {
  dials_.push_back({.address = address, .due = now, .backoff = options_.backoff_min});
}

void UdpNode::hang_up(std::uint64_t path, const std::string& reason, std::int64_t now) {
  now_ = now;
  const Address address = path_address(path);
  std::erase_if(dials_, [&](const Dial& dial) { return dial.address == address; });
  for (auto& [receiver, connection] : connections_) {
    if (connection.address != address) continue;
    connection.link->leave(reason, now);
    detach(connection);
  }
}

bool UdpNode::on_datagram(std::span<const std::byte> datagram, const Address& from,
                          std::int64_t now) {
  now_ = now;
  if (from.port == 0) {  // nobody sends from there
    ++unknown_;
    return false;
  }
  return receive(datagram, from, now);
}

bool UdpNode::on_packet(const ProtectedHeader& header, std::span<const std::byte> datagram,
                        const Address& from, std::int64_t now) {
  const auto at = connections_.find(header.receiver);
  const bool elsewhere = at != connections_.end() && at->second.address != from;
  // A relayed datagram is not relayed any further.
  if (at == connections_.end() || (elsewhere && !may_move(at->second, from)) ||
      (header.relay && is_relayed(from))) {
    ++unknown_;
    return false;
  }
  Connection& connection = at->second;
  // Also where a copy of it was here before: then it is not opened.
  if (!elsewhere && connection.moving && connection.moving->refuted_by(header.sequence)) {
    connection.moving.reset();
  }
  const bool first = !connection.link->confirmed();
  if (!connection.link->open(datagram, now)) {
    if (elsewhere) ++unknown_;
    return false;
  }
  if (first) attach(at->first, now);
  if (elsewhere) note_path(connection, header.sequence, from, datagram.size(), now);
  connection.link->read(now);
  answer_path(connection, from, now);
  if (!connection.attached) return true;
  Record& record = records_.at(connection.link->session().remote.peer);
  ++record.status.packets_in;
  record.status.bytes_in += datagram.size();
  const auto exchange = connection.link->take_exchange();
  if (exchange && options_.clock != Clock::None) {
    const ClockSample& times = exchange->sample;
    connection.round_trip = times.received - times.sent - (times.their_sent - times.their_received);
    clock_.on_exchange(record.status.id, times, exchange->claim);
  }
  for (const KnownPeer& known : connection.link->take_told()) on_told(connection, known, now);
  const auto change = connection.link->take_group_change();
  if (!change.empty()) on_group_change(connection, change, now);
  const auto relayed = connection.link->take_relayed();
  if (connection.link->state() != UdpConnection::State::Open) {
    detach(connection);
  } else if (relayed) {
    on_relayed(connection, *relayed, now);
  }
  return true;
}

bool UdpNode::receive(std::span<const std::byte> datagram, const Address& from, std::int64_t now) {
  if (const auto header = decode_protected_header(datagram)) {
    return on_packet(*header, datagram, from, now);
  }
  const auto packet = decode_handshake(datagram);
  if (packet &&
      (packet->type == HandshakeType::Challenge || packet->type == HandshakeType::Accept)) {
    for (Dial& dial : dials_) {
      if (dial.address != from || !dial.attempt) continue;
      dial.attempt->on_datagram(datagram, now);
      finish(dial, now);
    }
    return true;
  }
  const auto result = responder_.on_datagram(datagram, from, now);
  if (!result.reply.empty()) transmit(result.reply, from);
  if (result.session) open(*result.session, from, false, now);
  return !result.reply.empty();
}

void UdpNode::finish(Dial& dial, std::int64_t now) {
  using State = HandshakeInitiator::State;
  const State state = dial.attempt->state();
  if (state == State::Asking || state == State::Proving) return;
  const auto attempt = std::move(dial.attempt);
  dial.due = now + dial.backoff;
  dial.backoff = std::min(2 * dial.backoff, options_.backoff_max);
  if (state != State::Done) {
    // Who is refused because its predecessor was there a moment ago is let in soon.
    if (state == State::Refused && attempt->verdict() == Verdict::Outdated) {
      dial.backoff = options_.backoff_min;
    }
    const auto record = records_.find(dial.peer);
    if (record != records_.end() && !record->second.status.connected && !record->second.dropped) {
      record->second.status.reason = attempt->reason();
    }
    return;
  }
  dial.attempts = 0;
  dial.peer = attempt->session().remote.peer;
  const Session& session = attempt->session();
  const Verdict verdict = decide(session.remote, session.member, dial.address, now);
  if (verdict != Verdict::Welcome) return;
  open(session, dial.address, true, now);
}

bool UdpNode::is_wanted(const Dial& dial) const {
  const auto record = records_.find(dial.peer);
  if (leaving_) return false;
  if (record == records_.end()) return true;
  if (record->second.dropped || !options_.handshake.stands(record->second.member)) return false;
  // Also where it is connected by a relay only, and this is the straight way.
  return record->second.receiver == 0 ||
         (!is_relayed(dial.address) && !is_attached_directly(dial.peer));
}

void UdpNode::poll_dial(Dial& dial, std::int64_t now) {
  if (!is_wanted(dial)) {
    dial.attempt.reset();
    return;
  }
  if (!dial.attempt) {
    if (now < dial.due) return;
    // In turn: whoever is dialled may not have heard of the last change yet.
    const std::size_t key = dial.attempts++ % options_.handshake.key_count();
    dial.attempt = std::make_unique<HandshakeInitiator>(options_.handshake, random_,
                                                        free_receiver(), now, key);
  }
  const auto datagram = dial.attempt->poll(now);
  if (!datagram.empty()) transmit(datagram, dial.address);
  finish(dial, now);
}

void UdpNode::poll(std::int64_t now) {
  now_ = now;
  if (options_.clock != Clock::None && now >= clock_due_) {
    clock_.update(now);
    clock_due_ = now + ClockSync::kUpdate;
  }
  if (now >= mesh_due_) {
    look_for_relays(now);
    forget_dials(now);
    expel(now);
    mesh_due_ = now + kMeshPeriod;
  }
  const ClockClaim claim = clock_.claim(now);
  const ClockClaim* told = options_.clock == Clock::None ? nullptr : &claim;
  for (Dial& dial : dials_) poll_dial(dial, now);
  for (auto at = connections_.begin(); at != connections_.end();) {
    Connection& connection = at->second;
    introduce(connection, now);
    poll_path(connection, now);
    for (auto out = connection.link->poll(now, told); !out.empty();
         out = connection.link->poll(now, told)) {
      transmit(out, connection.address);
      if (!connection.attached) continue;
      Record& record = records_.at(connection.link->session().remote.peer);
      ++record.status.packets_out;
      record.status.bytes_out += out.size();
    }
    if (connection.link->state() != UdpConnection::State::Open) detach(connection);
    at = connection.link->state() == UdpConnection::State::Closed ? connections_.erase(at)
                                                                  : std::next(at);
  }
}

std::int64_t UdpNode::next_due(std::int64_t now) {
  constexpr std::int64_t kHandshakeStep = 10'000'000;  // how exactly its resends are kept
  std::int64_t due = INT64_MAX;
  for (const auto& [receiver, connection] : connections_) {
    due = std::min(due, connection.link->next_due(now));
    due = std::min(due, path_due(connection, now));
    if (connection.attached && options_.introduces) {
      due = std::min(due, std::max(now, connection.tell_due));
    }
  }
  for (const Dial& dial : dials_) {
    if (!is_wanted(dial)) continue;
    due = std::min(due, dial.attempt ? now + kHandshakeStep : std::max(now, dial.due));
  }
  return due;
}

void UdpNode::leave(const std::string& reason, std::int64_t now) {
  now_ = now;
  leaving_ = true;
  for (auto& [receiver, connection] : connections_) {
    connection.link->leave(reason, now);
    detach(connection);
  }
}

bool UdpNode::busy() const {
  return std::ranges::any_of(connections_, [](const auto& entry) {
    return entry.second.attached && !entry.second.link->channels().reliable().empty();
  });
}

bool UdpNode::post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
                   std::int64_t now) {
  Connection* connection = attached(to);
  if (connection == nullptr) return false;
  if (connection->link->post(bytes, delivery, now)) return true;
  ++records_.at(to).status.dropped_queue_full;
  return false;
}

void UdpNode::drain(std::vector<consensus::Packet>& out) {
  for (auto& [peer, record] : records_) {
    if (Connection* connection = attached(peer)) connection->link->drain(record.inbox);
    for (auto& message : record.inbox)
      out.push_back({.from = peer,
                     .bytes = std::move(message.bytes),
                     .received = clock_.at(message.at),
                     .role = record.member.role});
    record.inbox.clear();
  }
}

ClockStatus UdpNode::clock(std::int64_t now) {
  ClockStatus out = clock_.status(now);
  if (options_.clock == Clock::None) out.error_bound = -1;
  return out;
}

void UdpNode::drop(PeerId peer, const std::string& reason, std::int64_t now) {
  now_ = now;
  const auto at = records_.find(peer);
  if (at == records_.end()) return;
  if (Connection* connection = attached(peer)) {
    connection->link->leave("dropped: " + reason, now);
    detach(*connection);
  }
  Record& record = at->second;
  record.inbox.clear();
  if (record.reliable) record.reliable->sender.begin_anew();
  record.dropped = true;
  record.hold_until = now + options_.drop_hold;
  record.status.reason = "dropped: " + reason;
}

std::vector<consensus::PeerStatus> UdpNode::peers() const {
  std::vector<consensus::PeerStatus> out;
  for (const auto& [peer, record] : records_) {
    out.push_back(record.status);
    if (record.receiver == 0) continue;
    const UdpConnection& link = *connections_.at(record.receiver).link;
    out.back().dropped_queue_full += link.channels().dropped_states();
    out.back().rejected += link.rejected();
    out.back().over_budget += link.channels().budget().refused();
    out.back().round_trip = link.channels().rtt().any()
                                ? link.channels().rtt().smoothed()
                                : connections_.at(record.receiver).round_trip;
    out.back().kbit_per_s = link.congestion().rate();
  }
  return out;
}

}  // namespace tandem::net
