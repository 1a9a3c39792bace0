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

// Of what members tell about third peers.
constexpr std::int64_t kTellPeriod = 2'000'000'000;     // ns
constexpr std::size_t kTellAtOnce = 4;                  // peers in a turn
constexpr std::int64_t kMeshPeriod = 250'000'000;       // ns
constexpr std::int64_t kRelayPatience = 2'000'000'000;  // ns
constexpr std::int64_t kToldLife = 30'000'000'000;      // ns, of an address after it was told last
constexpr std::size_t kMaxTold = 64;                    // dials
constexpr std::ptrdiff_t kMaxToldBy = 16;               // by one member
constexpr std::ptrdiff_t kMaxToldOf = 4;                // addresses of one peer

}  // namespace

UdpNode::UdpNode(const UdpNodeOptions& options, const crypto::Random& random, Send send)
    : options_(options),
      random_(random),
      send_(std::move(send)),
      clock_(options.handshake.self, options.clock == Clock::Session, options.start,
             options.correction),
      responder_(
          options_.handshake, random,
          [this](const Introduction& other, const Address&) { return decide(other, now_); },
          [this] { return free_receiver(); }) {
  std::array<std::uint8_t, 2> bytes{};
  random_(bytes);
  receiver_prefix_ = static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

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
    std::array<std::uint8_t, 2> bytes{};
    random_(bytes);
    const std::uint32_t out = std::uint32_t{receiver_prefix_} << 16 | bytes[0] << 8 | bytes[1];
    const bool promised = std::ranges::any_of(dials_, [out](const Dial& dial) {
      return dial.attempt && dial.attempt->receiver() == out;
    });
    if (out != 0 && !promised && !connections_.contains(out)) return out;
  }
}

void UdpNode::open(const Session& session, const Address& address, bool began_here,
                   std::int64_t now) {
  Connection connection{
      .link = std::make_unique<UdpConnection>(session, options_.connection, began_here, now),
      .address = address,
      .began_here = began_here,
      .relay = Pacer(options_.relay_kbit, now)};
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
    const bool existing_direct = !is_relayed(existing->address);
    const bool worse = existing_direct != !is_relayed(connection.address)
                           ? existing_direct
                           : began_by_lower(*existing) && !began_by_lower(connection);
    if (older || (!newer && worse)) {
      connection.link->leave("another connection is kept", now);
      return;
    }
    existing->link->leave("replaced by a newer connection", now);
    detach(*existing);
  }
  if (record.incarnation != remote.incarnation) record.reliable.reset();
  if (record.reliable) connection.link->resume(*std::exchange(record.reliable, {}));
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
  acquaintances_.restart(remote.peer, now);
  connection.tell_due = now;
  if (is_relayed(connection.address)) return;
  for (auto& [number, other] : connections_) {
    if (other.attached && number != receiver) {
      other.link->tell({.peer = remote.peer, .address = connection.address});
    }
  }
}

void UdpNode::detach(Connection& connection) {
  if (!std::exchange(connection.attached, false)) return;
  Record& record = records_.at(connection.link->session().remote.peer);
  connection.link->drain(record.inbox);
  record.status.dropped_queue_full += connection.link->channels().dropped_states();
  record.status.rejected += connection.link->rejected();
  record.reliable = connection.link->take_reliable();
  record.departure = ++departures_;
  acquaintances_.restart(record.status.id, now_);
  clock_.lost(record.status.id);
  record.receiver = 0;
  record.status.connected = false;
  record.status.reason = connection.link->reason();
  shed_departed();
}

void UdpNode::shed_departed() {
  // What waits for those that are gone: of the latest only.
  std::size_t count = 0;
  Record* oldest = nullptr;
  for (auto& [peer, record] : records_) {
    if (!record.reliable || record.reliable->sender.empty()) continue;
    ++count;
    if (oldest == nullptr || record.departure < oldest->departure) oldest = &record;
  }
  if (count > options_.max_peers) oldest->reliable->sender.begin_anew();
}

bool UdpNode::on_datagram(std::span<const std::byte> datagram, const Address& from,
                          std::int64_t now) {
  now_ = now;
  if (is_relayed(from)) {  // nobody sends from port 0
    ++unknown_;
    return false;
  }
  return receive(datagram, from, now);
}

bool UdpNode::on_packet(const ProtectedHeader& header, std::span<const std::byte> datagram,
                        const Address& from, std::int64_t now) {
  const auto at = connections_.find(header.receiver);
  // A relayed datagram is not relayed any further.
  if (at == connections_.end() || at->second.address != from ||
      (header.relay && is_relayed(from))) {
    ++unknown_;
    return false;
  }
  Connection& connection = at->second;
  const bool first = !connection.link->confirmed();
  if (!connection.link->open(datagram, now)) return false;
  if (first) attach(at->first, now);
  connection.link->read(now);
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
  const auto relayed = connection.link->take_relayed();
  if (connection.link->state() != UdpConnection::State::Open) {
    detach(connection);
  } else if (relayed) {
    on_relayed(connection, *relayed, now);
  }
  return true;
}

void UdpNode::on_told(Connection& connection, const KnownPeer& known, std::int64_t now) {
  const PeerId teller = connection.link->session().remote.peer;
  if (known.peer == 0 || known.peer == options_.handshake.self || known.peer == teller) return;
  if (!is_host(known.address)) return;
  if (!is_relayed(connection.address)) acquaintances_.note(known.peer, teller, now);
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

void UdpNode::introduce(Connection& connection, std::int64_t now) {
  if (!connection.attached || now < connection.tell_due) return;
  const PeerId other = connection.link->session().remote.peer;
  // The next ones in the order of their ids, after whom it was told of last.
  std::size_t told = 0;
  auto at = records_.upper_bound(connection.told_to);
  for (; at != records_.end() && told < kTellAtOnce; ++at) {
    if (at->first == other || !is_attached_directly(at->first)) continue;
    connection.link->tell(
        {.peer = at->first, .address = connections_.at(at->second.receiver).address});
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
  // Also where it is connected by a relay only, and this is the straight way.
  const bool missing = record == records_.end() || record->second.receiver == 0 ||
                       (!is_relayed(dial.address) && !is_attached_directly(dial.peer));
  const bool wanted = missing && (record == records_.end() || !record->second.dropped);
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
    mesh_due_ = now + kMeshPeriod;
  }
  const ClockClaim claim = clock_.claim(now);
  const ClockClaim* told = options_.clock == Clock::None ? nullptr : &claim;
  for (Dial& dial : dials_) poll_dial(dial, now);
  for (auto at = connections_.begin(); at != connections_.end();) {
    Connection& connection = at->second;
    introduce(connection, now);
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
    if (connection.attached) due = std::min(due, std::max(now, connection.tell_due));
  }
  if (!dials_.empty() && !leaving_) due = std::min(due, now + kHandshakeStep);
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
      out.push_back(
          {.from = peer, .bytes = std::move(message.bytes), .received = clock_.at(message.at)});
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
    out.back().round_trip = link.channels().rtt().any()
                                ? link.channels().rtt().smoothed()
                                : connections_.at(record.receiver).round_trip;
    out.back().kbit_per_s = link.congestion().rate();
  }
  return out;
}

}  // namespace tandem::net
