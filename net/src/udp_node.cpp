// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_node.h"

#include <algorithm>
#include <utility>

namespace tandem::net {

using consensus::PeerId;

namespace {

/// Records of peers that are gone are kept for their status; whoever makes up ids must not fill the
/// memory with them.
constexpr std::size_t kMaxRecords = 1024;

}  // namespace

UdpNode::UdpNode(const UdpNodeOptions& options, const crypto::Random& random, Send send)
    : options_(options),
      random_(random),
      send_(std::move(send)),
      responder_(
          options_.handshake, random,
          [this](const Introduction& other, const Address&) { return decide(other, now_); },
          [this] { return free_receiver(); }) {}

void UdpNode::dial(const Address& address, std::int64_t now) {
  dials_.push_back({.address = address, .due = now, .backoff = options_.backoff_min});
}

std::size_t UdpNode::attached_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      records_, [](const auto& entry) { return entry.second.receiver != 0; }));
}

Verdict UdpNode::decide(const Introduction& other, std::int64_t now) const {
  if (leaving_) return Verdict::Full;
  const auto found = records_.find(other.peer);
  if (found == records_.end()) {
    if (records_.size() >= kMaxRecords) return Verdict::Full;
  } else {
    if (other.incarnation < found->second.incarnation) return Verdict::Outdated;
    if (now < found->second.hold_until) return Verdict::OnHold;
  }
  const bool is_here = found != records_.end() && found->second.receiver != 0;
  if (!is_here && attached_count() >= options_.max_peers) return Verdict::Full;
  // As many again that are not confirmed or are leaving.
  return connections_.size() < 2 * options_.max_peers ? Verdict::Welcome : Verdict::Full;
}

std::uint32_t UdpNode::free_receiver() {
  for (;;) {
    std::array<std::uint8_t, 4> bytes{};
    random_(bytes);
    std::uint32_t out = 0;
    for (const std::uint8_t byte : bytes) out = out << 8 | byte;
    const bool promised = std::ranges::any_of(dials_, [out](const Dial& dial) {
      return dial.attempt && dial.attempt->receiver() == out;
    });
    if (out != 0 && !promised && !connections_.contains(out)) return out;
  }
}

void UdpNode::open(const Session& session, const Address& address, bool began_here,
                   std::int64_t now) {
  Connection connection;
  connection.link = std::make_unique<UdpConnection>(session, options_.connection, began_here, now);
  connection.address = address;
  connection.began_here = began_here;
  connections_.insert_or_assign(session.local_receiver, std::move(connection));
  if (began_here) attach(session.local_receiver, now);
}

UdpNode::Connection* UdpNode::attached(PeerId peer) {
  const auto record = records_.find(peer);
  if (record == records_.end() || record->second.receiver == 0) return nullptr;
  return &connections_.at(record->second.receiver);
}

void UdpNode::attach(std::uint32_t receiver, std::int64_t now) {
  Connection& connection = connections_.at(receiver);
  const Introduction& remote = connection.link->session().remote;
  // Asked again: several may have been half open when there was room for one.
  if (attached(remote.peer) == nullptr && attached_count() >= options_.max_peers) {
    connection.link->leave(describe(Verdict::Full), now);
    return;
  }
  Record& record = records_[remote.peer];
  record.status.id = remote.peer;
  const auto began_by_lower = [&](const Connection& c) {
    return c.began_here == (options_.handshake.self < remote.peer);
  };
  if (Connection* existing = attached(remote.peer)) {
    const bool newer = remote.incarnation > record.incarnation;
    const bool older = remote.incarnation < record.incarnation;
    if (older || (!newer && began_by_lower(*existing) && !began_by_lower(connection))) {
      connection.link->leave("another connection is kept", now);
      return;
    }
    existing->link->leave("replaced by a newer connection", now);
    detach(*existing);
  }
  record.incarnation = remote.incarnation;
  record.receiver = receiver;
  record.dropped = false;
  record.status.connected = true;
  record.status.reason.clear();
  connection.attached = true;
  for (Dial& dial : dials_) {
    if (dial.address == connection.address) dial.peer = remote.peer;
    if (dial.peer == remote.peer) dial.backoff = options_.backoff_min;
  }
}

void UdpNode::detach(Connection& connection) {
  if (!std::exchange(connection.attached, false)) return;
  Record& record = records_.at(connection.link->session().remote.peer);
  connection.link->drain(record.inbox);
  record.status.dropped_queue_full += connection.link->channels().dropped_states();
  record.status.rejected += connection.link->rejected();
  record.receiver = 0;
  record.status.connected = false;
  record.status.reason = connection.link->reason();
}

void UdpNode::on_datagram(std::span<const std::byte> datagram, const Address& from,
                          std::int64_t now) {
  now_ = now;
  if (const auto header = decode_protected_header(datagram)) {
    const auto at = connections_.find(header->receiver);
    if (at == connections_.end() || at->second.address != from) {
      ++unknown_;
      return;
    }
    Connection& connection = at->second;
    const bool first = !connection.link->confirmed();
    if (!connection.link->on_datagram(datagram, now)) return;
    if (first) attach(at->first, now);
    if (connection.attached) {
      Record& record = records_.at(connection.link->session().remote.peer);
      ++record.status.packets_in;
      record.status.bytes_in += datagram.size();
      if (connection.link->state() != UdpConnection::State::Open) detach(connection);
    }
    return;
  }
  const auto packet = decode_handshake(datagram);
  if (packet &&
      (packet->type == HandshakeType::Challenge || packet->type == HandshakeType::Accept)) {
    for (Dial& dial : dials_) {
      if (dial.address != from || !dial.attempt) continue;
      dial.attempt->on_datagram(datagram, now);
      finish(dial, now);
    }
    return;
  }
  const auto result = responder_.on_datagram(datagram, from, now);
  if (!result.reply.empty()) send_(result.reply, from);
  if (result.session) open(*result.session, from, false, now);
}

void UdpNode::finish(Dial& dial, std::int64_t now) {
  using State = HandshakeInitiator::State;
  const State state = dial.attempt->state();
  if (state == State::Asking || state == State::Proving) return;
  const auto attempt = std::move(dial.attempt);
  dial.due = now + dial.backoff;
  dial.backoff = std::min(2 * dial.backoff, options_.backoff_max);
  if (state != State::Done) {
    const auto record = records_.find(dial.peer);
    if (record != records_.end() && !record->second.status.connected && !record->second.dropped) {
      record->second.status.reason = attempt->reason();
    }
    return;
  }
  dial.peer = attempt->session().remote.peer;
  if (decide(attempt->session().remote, now) != Verdict::Welcome) return;
  open(attempt->session(), dial.address, true, now);
}

void UdpNode::poll_dial(Dial& dial, std::int64_t now) {
  const auto record = records_.find(dial.peer);
  const bool wanted =
      record == records_.end() || (record->second.receiver == 0 && !record->second.dropped);
  if (leaving_ || !wanted) {
    dial.attempt.reset();
    return;
  }
  if (!dial.attempt) {
    if (now < dial.due) return;
    dial.attempt =
        std::make_unique<HandshakeInitiator>(options_.handshake, random_, free_receiver(), now);
  }
  const auto datagram = dial.attempt->poll(now);
  if (!datagram.empty()) send_(datagram, dial.address);
  finish(dial, now);
}

void UdpNode::poll(std::int64_t now) {
  now_ = now;
  for (Dial& dial : dials_) poll_dial(dial, now);
  for (auto at = connections_.begin(); at != connections_.end();) {
    Connection& connection = at->second;
    for (auto out = connection.link->poll(now); !out.empty(); out = connection.link->poll(now)) {
      send_(out, connection.address);
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
  }
  if (!dials_.empty() && !leaving_) due = std::min(due, now + kHandshakeStep);
  return due;
}

void UdpNode::leave(const std::string& reason, std::int64_t now) {
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
      out.push_back({.from = peer, .bytes = std::move(message.bytes)});
    record.inbox.clear();
  }
}

void UdpNode::drop(PeerId peer, const std::string& reason, std::int64_t now) {
  const auto at = records_.find(peer);
  if (at == records_.end()) return;
  if (Connection* connection = attached(peer)) {
    connection->link->leave("dropped: " + reason, now);
    detach(*connection);
  }
  Record& record = at->second;
  record.inbox.clear();
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
    out.back().kbit_per_s = link.congestion().rate();
  }
  return out;
}

}  // namespace tandem::net
