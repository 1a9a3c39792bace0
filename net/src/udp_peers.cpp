// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_peers.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace tandem::net {

namespace {

/// Unconfirmed connections begun by other peers, of one key and of all. An honest peer confirms in
/// one round trip: 427 ms at 300 a second.
constexpr std::size_t kMaxUnconfirmedOfKey = 32;
constexpr std::size_t kMaxUnconfirmed = 128;
constexpr std::int64_t kTellPeriod = 2'000'000'000;  // ns
constexpr std::size_t kTellAtOnce = 4;               // peers per turn

/// A path is local to us. An announcement without an address still shows whom to ask for a relay.
Address told_address(const Address& address) { return is_path(address) ? Address{} : address; }

}  // namespace

const UdpPeers::Record* UdpPeers::record(PeerId peer) const {
  const auto at = records_.find(peer);
  return at != records_.end() ? &at->second : nullptr;
}

UdpPeers::Connection* UdpPeers::attached(PeerId peer) const {
  const Record* found = record(peer);
  return found != nullptr ? found->connection : nullptr;
}

bool UdpPeers::is_attached_directly(PeerId peer) const {
  const Connection* connection = attached(peer);
  return connection != nullptr && !is_relayed(connection->path.address());
}

std::size_t UdpPeers::attached_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      records_, [](const auto& entry) { return entry.second.connection != nullptr; }));
}

bool UdpPeers::is_taken(const Record& record, const Member& member, std::int64_t now) {
  return !member.bound && record.connection != nullptr && record.member.key != member.key &&
         !record.connection->link->silent(now);
}

Verdict UdpPeers::decide(const Introduction& other, const Member& member, const Address& from,
                         std::int64_t now) {
  if (leaving_) return Verdict::Full;
  // The forwarding peer could be the other end itself.
  if (is_relayed(from) && !member.bound) return Verdict::Unbound;
  const Record* found = record(other.peer);
  const bool is_here = found != nullptr && found->connection != nullptr;
  if (found != nullptr && now < found->hold_until) return Verdict::OnHold;
  if (is_here && is_taken(*found, member, now)) return Verdict::Taken;
  // The incarnation orders two processes of one peer. It comes from a clock that may be wrong, so
  // that of one that has left is ignored.
  if (is_here && other.incarnation < found->incarnation && !found->connection->link->silent(now)) {
    return Verdict::Outdated;
  }
  if (!is_here && attached_count() >= options_.max_peers &&
      guest_in_place_of(other.peer, member) == nullptr) {
    return Verdict::Full;
  }
  const auto confirmed = std::ranges::count_if(
      connections_, [](const auto& entry) { return entry.second.link->confirmed(); });
  // Twice as many, as some are leaving.
  return static_cast<std::size_t>(confirmed) < 2 * options_.max_peers ? Verdict::Welcome
                                                                      : Verdict::Full;
}

UdpPeers::Connection& UdpPeers::add(const Session& session, const Address& address, bool began_here,
                                    std::int64_t now) {
  if (!began_here) forget_unconfirmed(session.member.key);
  UdpConnectionOptions options = options_.connection;
  // Carried in other datagrams, which limit the length.
  if (address.port == 0) {
    const bool known = is_path(address) && options_.path_limit != nullptr;
    options.max_datagram = std::min(
        options.max_datagram,
        known ? std::max(options_.path_limit(path_number(address)), kMaxRelayed) : kMaxRelayed);
  }
  auto link = std::make_unique<UdpConnection>(session, options, began_here, now);
  ConnectionPath path(*link, address);
  if (is_path(address) && !options_.direct_addresses.empty()) path.add_direct();
  return connections_
      .insert_or_assign(session.local_receiver,
                        Connection{.link = std::move(link),
                                   .path = path,
                                   .began_here = began_here,
                                   .opened = now,
                                   .relay = Pacer(options_.relay_kbit, now)})
      .first->second;
}

UdpPeers::Record* UdpPeers::guest_in_place_of(PeerId peer, const Member& member) {
  return who_gives_way(records_, peer, member,
                       [](const Record& record) { return record.connection != nullptr; });
}

void UdpPeers::forget_unconfirmed(const crypto::PublicKey& key) {
  std::vector<Asking> all;
  std::size_t of_key = 0;
  for (const auto& [receiver, connection] : connections_) {
    if (connection.began_here || connection.link->confirmed()) continue;
    const auto& member = connection.link->session().member;
    all.push_back({member.key, network_of(connection.path.address()), connection.opened, receiver});
    if (member.key == key) ++of_key;
  }
  // Anybody with the session key can name any member's key: connections of other networks stay.
  if (of_key >= kMaxUnconfirmedOfKey) {
    std::erase_if(all, [&key](const Asking& each) { return each.key != key; });
  } else if (all.size() < kMaxUnconfirmed) {
    return;
  }
  connections_.erase(static_cast<std::uint32_t>(first_to_go(all)));
}

bool UdpPeers::is_asked(const Address& address) const {
  return std::ranges::any_of(connections_, [&](const auto& entry) {
    const Connection& each = entry.second;
    return each.began_here && !each.link->confirmed() &&
           each.link->state() == UdpConnection::State::Open && each.path.address() == address;
  });
}

void UdpPeers::forget_departed() {
  if (records_.size() < 2 * options_.max_peers &&
      records_.size() - attached_count() < options_.max_departed) {
    return;
  }
  auto oldest = records_.end();
  for (auto at = records_.begin(); at != records_.end(); ++at) {
    if (at->second.connection != nullptr) continue;
    // First those that stayed briefly.
    const auto worth = [](const Record& record) {
      return std::tuple(record.seniority.stayed(), record.departure);
    };
    if (oldest == records_.end() || worth(at->second) < worth(oldest->second)) oldest = at;
  }
  if (oldest != records_.end()) records_.erase(oldest);
}

bool UdpPeers::attach(Connection& connection, std::int64_t now) {
  const Introduction& remote = connection.link->session().remote;
  // Checked again: several may have been half open when there was room for one.
  if (attached(remote.peer) == nullptr && attached_count() >= options_.max_peers) {
    Record* const guest = guest_in_place_of(remote.peer, connection.link->session().member);
    if (guest == nullptr) {
      connection.link->leave(describe(Verdict::Full), now);
      return false;
    }
    guest->connection->link->leave(describe(Verdict::Full), now);
    detach(*guest->connection);
  }
  if (!records_.contains(remote.peer)) forget_departed();
  Record& record = records_[remote.peer];
  record.status.id = remote.peer;
  const auto began_by_lower = [&](const Connection& c) {
    return c.began_here == (options_.handshake.self < remote.peer);
  };
  const Member& member = connection.link->session().member;
  if (is_taken(record, member, now)) {
    connection.link->leave(describe(Verdict::Taken), now);
    return false;
  }
  const bool same_process =
      record.incarnation == remote.incarnation && record.member.key == member.key;
  if (Connection* existing = record.connection) {
    const bool newer = remote.incarnation > record.incarnation;
    const bool older = remote.incarnation < record.incarnation;
    const bool existing_direct = !is_relayed(existing->path.address());
    const bool worse = existing_direct != !is_relayed(connection.path.address())
                           ? existing_direct
                           : began_by_lower(*existing) && !began_by_lower(connection);
    if (!existing->link->silent(now) && (older || (!newer && worse))) {
      connection.link->leave("another connection is kept", now);
      return false;
    }
    existing->link->leave("replaced by a newer connection", now);
    detach(*existing);
  }
  if (!same_process) record.reliable.reset();
  if (record.reliable) {
    connection.link->channels().resume(*std::exchange(record.reliable, {}));
  }
  record.seniority.arrive(record.member.key == member.key, ++events_);
  record.incarnation = remote.incarnation;
  record.member = member;
  record.status.role = member.role;
  record.connection = &connection;
  record.dropped = false;
  record.status.connected = true;
  record.status.reason.clear();
  connection.record = &record;
  return true;
}

void UdpPeers::detach(Connection& connection) {
  if (connection.record == nullptr) return;
  Record& record = *std::exchange(connection.record, nullptr);
  Channels& channels = connection.link->channels();
  channels.inbox().drain(record.inbox);
  record.status.dropped_queue_full += channels.dropped_states();
  record.status.rejected += connection.link->rejected();
  record.status.over_budget += channels.inbox().budget().refused();
  record.reliable = channels.take_reliable();
  record.departure = ++events_;
  record.seniority.stay(connection.link->last_heard() - connection.opened);
  lost_(record.status.id);
  record.connection = nullptr;
  record.status.connected = false;
  record.status.reason = connection.link->reason();
  shed_departed();
}

void UdpPeers::shed_departed() {
  // Keep undelivered messages for the latest departed peers only.
  std::size_t count = 0;
  Record* oldest = nullptr;
  for (auto& [peer, record] : records_) {
    if (!record.reliable || record.reliable->sender.empty()) continue;
    ++count;
    if (oldest == nullptr || record.departure < oldest->departure) oldest = &record;
  }
  if (count > options_.max_peers) oldest->reliable->sender.begin_anew();
}

void UdpPeers::drop(PeerId peer, const std::string& reason, std::int64_t now) {
  const auto at = records_.find(peer);
  if (at == records_.end()) return;
  Record& record = at->second;
  if (record.connection != nullptr) {
    record.connection->link->leave("dropped: " + reason, now);
    detach(*record.connection);
  }
  record.inbox.clear();
  if (record.reliable) record.reliable->sender.begin_anew();
  record.dropped = true;
  record.hold_until = now + options_.drop_hold;
  record.status.reason = "dropped: " + reason;
}

void UdpPeers::expel(std::int64_t now) {
  for (auto& [receiver, connection] : connections_) {
    const Member& member = connection.link->session().member;
    if (options_.handshake.stands(member)) continue;
    const bool revoked = options_.handshake.is_revoked(member.key);
    connection.link->leave(describe(revoked ? Verdict::Revoked : Verdict::Expired), now);
    Record* record = connection.record;
    if (record == nullptr) continue;
    detach(connection);
    record->inbox.clear();
    record->reliable.reset();
  }
}

void UdpPeers::leave(const std::string& reason, std::int64_t now) {
  leaving_ = true;
  for (auto& [receiver, connection] : connections_) {
    connection.link->leave(reason, now);
    detach(connection);
  }
}

void UdpPeers::note_failure(PeerId peer, const std::string& reason) {
  if (peer == 0 || peer == options_.handshake.self) return;
  if (!records_.contains(peer)) forget_departed();
  Record& record = records_[peer];
  record.status.id = peer;
  if (!record.status.connected && !record.dropped) record.status.reason = reason;
}

bool UdpPeers::post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
                    std::int64_t now) {
  Connection* connection = attached(to);
  if (connection == nullptr) return false;
  if (connection->link->post(bytes, delivery, now)) return true;
  ++connection->record->status.dropped_queue_full;
  return false;
}

void UdpPeers::drain(const ClockSync& clock, std::vector<consensus::Packet>& out) {
  for (auto& [peer, record] : records_) {
    if (record.connection != nullptr) {
      record.connection->link->channels().inbox().drain(record.inbox);
    }
    for (auto& message : record.inbox)
      out.push_back({.from = peer,
                     .bytes = std::move(message.bytes),
                     .received = clock.at(message.at),
                     .role = record.member.role});
    record.inbox.clear();
  }
}

void UdpPeers::list(std::vector<consensus::PeerStatus>& out) const {
  out.resize(records_.size());
  auto next = out.begin();
  for (const auto& [peer, record] : records_) {
    consensus::PeerStatus& status = *next++;
    status = record.status;
    if (record.connection == nullptr) continue;
    const UdpConnection& link = *record.connection->link;
    const RttEstimate& rtt = link.channels().rtt();
    status.dropped_queue_full += link.channels().dropped_states();
    status.rejected += link.rejected();
    status.over_budget += link.channels().inbox().budget().refused();
    status.round_trip = rtt.any() ? rtt.smoothed() : record.connection->round_trip;
    status.kbit_per_s = link.congestion().rate();
  }
}

bool UdpPeers::busy() const {
  return std::ranges::any_of(connections_, [](const auto& entry) {
    return entry.second.record != nullptr && !entry.second.link->channels().reliable().empty();
  });
}

void UdpPeers::prefer_direct(std::span<const PeerId> peers, std::int64_t now) {
  for (auto& [receiver, connection] : connections_) {
    DirectWay* const direct = connection.path.direct();
    if (direct == nullptr || connection.record == nullptr) continue;
    direct->want(std::ranges::binary_search(peers, connection.record->status.id), *connection.link,
                 now);
  }
}

std::size_t UdpPeers::direct() {
  return static_cast<std::size_t>(std::ranges::count_if(connections_, [](auto& entry) {
    DirectWay* const direct = entry.second.path.direct();
    return entry.second.record != nullptr && direct != nullptr && !direct->uses_path();
  }));
}

void UdpPeers::tell_others(const Connection& connection) {
  if (!options_.introduces) return;
  const PeerId peer = connection.link->session().remote.peer;
  for (auto& [number, other] : connections_) {
    if (other.record == nullptr || &other == &connection) continue;
    other.link->channels().tell({.peer = peer, .address = told_address(connection.path.address())});
  }
}

void UdpPeers::introduce(Connection& connection, std::int64_t now) {
  if (connection.record == nullptr || now < connection.tell_due) return;
  DirectWay* const direct = connection.path.direct();
  if (direct != nullptr && direct->searches()) {
    for (const Address& own : options_.direct_addresses) {
      connection.link->channels().tell({.peer = options_.handshake.self, .address = own});
    }
    connection.tell_due = now + kTellPeriod;
  }
  if (!options_.introduces) return;
  const PeerId other = connection.link->session().remote.peer;
  // The next ones by id, after the last one announced.
  std::size_t told = 0;
  auto at = records_.upper_bound(connection.told_to);
  for (; at != records_.end() && told < kTellAtOnce; ++at) {
    if (at->first == other || !is_attached_directly(at->first)) continue;
    connection.link->channels().tell(
        {.peer = at->first, .address = told_address(at->second.connection->path.address())});
    connection.told_to = at->first;
    ++told;
  }
  const bool round = at == records_.end();
  if (round) connection.told_to = 0;
  connection.tell_due = now + (round ? kTellPeriod : kTellPeriod / 10);
}

}  // namespace tandem::net
