// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Which connection is a peer's: who is let in, which of two is kept, what is kept of who has gone.
#include <algorithm>
#include <utility>

#include "udp_node.h"

namespace tandem::net {

using consensus::PeerId;

namespace {

/// Connections that somebody has begun and not gone on with. Who goes on does so in one round trip,
/// so that the oldest may go.
constexpr std::size_t kMaxUnconfirmed = 16;

}  // namespace

std::size_t UdpNode::attached_count() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      records_, [](const auto& entry) { return entry.second.receiver != 0; }));
}

bool UdpNode::is_taken(const Record& record, const Member& member, std::int64_t now) const {
  return !member.bound && record.receiver != 0 && record.member.key != member.key &&
         !connections_.at(record.receiver).link->silent(now);
}

Verdict UdpNode::decide(const Introduction& other, const Member& member, const Address& from,
                        std::int64_t now) const {
  if (leaving_) return Verdict::Full;
  // Whoever passes the handshake on could be its other end.
  if (is_relayed(from) && !member.bound) return Verdict::Unbound;
  const auto found = records_.find(other.peer);
  const bool is_here = found != records_.end() && found->second.receiver != 0;
  if (found != records_.end() && now < found->second.hold_until) return Verdict::OnHold;
  if (is_here && is_taken(found->second, member, now)) return Verdict::Taken;
  // An incarnation says which of two processes is meant. It comes from a clock that may be wrong,
  // so that of one that is gone says nothing.
  if (is_here && other.incarnation < found->second.incarnation &&
      !connections_.at(found->second.receiver).link->silent(now)) {
    return Verdict::Outdated;
  }
  if (!is_here && attached_count() >= options_.max_peers) return Verdict::Full;
  const auto confirmed = std::ranges::count_if(
      connections_, [](const auto& entry) { return entry.second.link->confirmed(); });
  // As many again that are leaving.
  return static_cast<std::size_t>(confirmed) < 2 * options_.max_peers ? Verdict::Welcome
                                                                      : Verdict::Full;
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
  if (!began_here) forget_unconfirmed();
  UdpConnectionOptions link = options_.connection;
  // In other datagrams, whose length is not ours to choose.
  if (address.port == 0) {
    const bool known = is_path(address) && options_.path_limit != nullptr;
    link.max_datagram = std::min(
        link.max_datagram,
        known ? std::max(options_.path_limit(path_number(address)), kMaxRelayed) : kMaxRelayed);
  }
  Connection connection{.link = std::make_unique<UdpConnection>(session, link, began_here, now),
                        .address = address,
                        .began_here = began_here,
                        .opened = now,
                        .relay = Pacer(options_.relay_kbit, now)};
  connections_.insert_or_assign(session.local_receiver, std::move(connection));
  if (began_here) attach(session.local_receiver, now);
}

void UdpNode::forget_unconfirmed() {
  auto oldest = connections_.end();
  std::size_t count = 0;
  for (auto at = connections_.begin(); at != connections_.end(); ++at) {
    if (at->second.link->confirmed()) continue;
    ++count;
    if (oldest == connections_.end() || at->second.opened < oldest->second.opened) oldest = at;
  }
  if (count >= kMaxUnconfirmed) connections_.erase(oldest);
}

void UdpNode::forget_departed() {
  if (records_.size() < 2 * options_.max_peers) return;
  auto oldest = records_.end();
  for (auto at = records_.begin(); at != records_.end(); ++at) {
    if (at->second.receiver != 0) continue;
    if (oldest == records_.end() || at->second.departure < oldest->second.departure) oldest = at;
  }
  if (oldest != records_.end()) records_.erase(oldest);
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
  if (!records_.contains(remote.peer)) forget_departed();
  Record& record = records_[remote.peer];
  record.status.id = remote.peer;
  const auto began_by_lower = [&](const Connection& c) {
    return c.began_here == (options_.handshake.self < remote.peer);
  };
  const Member& member = connection.link->session().member;
  if (is_taken(record, member, now)) {
    connection.link->leave(describe(Verdict::Taken), now);
    return;
  }
  const bool same_process =
      record.incarnation == remote.incarnation && record.member.key == member.key;
  if (Connection* existing = attached(remote.peer)) {
    const bool newer = remote.incarnation > record.incarnation;
    const bool older = remote.incarnation < record.incarnation;
    const bool existing_direct = !is_relayed(existing->address);
    const bool worse = existing_direct != !is_relayed(connection.address)
                           ? existing_direct
                           : began_by_lower(*existing) && !began_by_lower(connection);
    if (!existing->link->silent(now) && (older || (!newer && worse))) {
      connection.link->leave("another connection is kept", now);
      return;
    }
    existing->link->leave("replaced by a newer connection", now);
    detach(*existing);
  }
  if (!same_process) record.reliable.reset();
  if (record.reliable) connection.link->channels().resume(*std::exchange(record.reliable, {}));
  record.incarnation = remote.incarnation;
  record.member = member;
  record.status.role = member.role;
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
  const auto& change = options_.handshake.group_change;
  if (!change.empty()) connection.link->channels().post_group_change(change);
  connection.tell_due = now;
  if (is_relayed(connection.address)) return;
  tell_others(connection);
}

void UdpNode::detach(Connection& connection) {
  if (!std::exchange(connection.attached, false)) return;
  Record& record = records_.at(connection.link->session().remote.peer);
  connection.link->channels().inbox().drain(record.inbox);
  record.status.dropped_queue_full += connection.link->channels().dropped_states();
  record.status.rejected += connection.link->rejected();
  record.status.over_budget += connection.link->channels().inbox().budget().refused();
  record.reliable = connection.link->channels().take_reliable();
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

}  // namespace tandem::net
