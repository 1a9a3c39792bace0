// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer_table.h"

#include <algorithm>
#include <chrono>
#include <tuple>
#include <utility>

namespace tandem::net {

using consensus::Delivery;

// ---- application's thread ----

PeerTable::PostResult PeerTable::post(PeerId to, std::span<const std::byte> bytes,
                                      Delivery delivery) {
  const std::lock_guard lock(mutex_);
  Record* record = find(to);
  if (record == nullptr || record->link == 0 || bytes.size() > record->max_payload) return {};

  if (!record->outgoing.make_room(bytes.size(), options_.send_queue_bytes,
                                  record->status.dropped_queue_full)) {
    ++record->status.dropped_queue_full;
    if (delivery == Delivery::Newest) return {};
    const std::uint64_t link = record->link;
    disconnect(*record, "send queue full of reliable frames, peer does not keep up");
    return {.cut_link = link};
  }
  record->outgoing.push(delivery, bytes);
  return {.accepted = true, .wake = !std::exchange(record->wake_posted, true)};
}

void PeerTable::drain(std::vector<consensus::Packet>& out) {
  const std::lock_guard lock(mutex_);
  for (auto& [id, record] : records_) {
    while (!record.inbox.empty()) {
      QueuedFrame frame = record.inbox.pop();
      out.push_back({.from = id,
                     .bytes = std::move(frame.bytes),
                     .received = frame.received,
                     .role = record.status.role});
    }
  }
}

std::uint64_t PeerTable::drop(PeerId peer, const std::string& reason, SteadyTime now) {
  const std::lock_guard lock(mutex_);
  Record* record = find(peer);
  if (record == nullptr) return 0;
  const std::uint64_t link = record->link;
  ban(*record, "dropped: " + reason, now);
  return link;
}

std::vector<consensus::PeerStatus> PeerTable::peers() const {
  const std::lock_guard lock(mutex_);
  std::vector<consensus::PeerStatus> out;
  out.reserve(records_.size());
  for (const auto& [id, record] : records_) out.push_back(record.status);
  return out;
}

std::uint64_t PeerTable::incarnation(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Record* record = find(peer);
  return record != nullptr ? record->incarnation : 0;
}

// ---- network thread ----

std::optional<std::string> PeerTable::refusal(const Hello& hello, const Member& member,
                                              SteadyTime now) {
  const std::lock_guard lock(mutex_);
  return refusal_locked(hello, member, now);
}

std::optional<std::string> PeerTable::refusal_locked(const Hello& hello, const Member& member,
                                                     SteadyTime now) {
  const Record* record = find(hello.peer);
  if (record != nullptr && now < record->hold_until) {
    return record->status.reason + " (on hold)";
  }
  if (record != nullptr && record->link != 0 && !member.bound && record->member.key != member.key) {
    return "another key goes by peer id " + std::to_string(hello.peer);
  }
  // Of two processes present the newer one wins. One that has left does not count: its clock may
  // have been ahead.
  if (record != nullptr && record->link != 0 && hello.incarnation < record->incarnation) {
    return "a newer process has taken peer id " + std::to_string(hello.peer);
  }
  if ((record == nullptr || record->link == 0) && connected_ >= options_.max_peers &&
      guest_in_place_of(hello.peer, member) == nullptr) {
    return "session full: " + std::to_string(connected_) + " peers";
  }
  return {};
}

std::uint64_t PeerTable::received(PeerId peer, std::uint64_t incarnation, const Key& key) const {
  const std::lock_guard lock(mutex_);
  const Record* record = find(peer);
  const bool same =
      record != nullptr && record->incarnation == incarnation && record->member.key == key;
  return same ? record->last_received : 0;
}

PeerTable::AttachResult PeerTable::attach(std::uint64_t link, const Hello& hello,
                                          const Member& member, const Welcome& theirs,
                                          std::uint64_t ticket, SteadyTime now) {
  const std::lock_guard lock(mutex_);
  if (auto reason = refusal_locked(hello, member, now)) return {.reason = std::move(*reason)};
  Record* record = find_or_add(hello.peer);
  if (record == nullptr) return {.reason = "too many peer ids"};

  const bool same_process =
      record->incarnation == hello.incarnation && record->member.key == member.key;
  if (same_process && record->link != 0 && ticket < record->ticket) {
    return {.reason = "replaced by a newer connection"};
  }
  if (same_process && !record->outgoing.has_written(theirs.received)) {
    return {.reason = "acknowledges frames that were never sent"};
  }
  AttachResult out{.attached = true, .replaced_link = record->link, .reason = {}};
  if (record->link != 0) {
    out.reason = "replaced by a newer connection";
    disconnect(*record, {});
  } else if (connected_ >= options_.max_peers) {
    Record& guest = *guest_in_place_of(hello.peer, member);  // refusal_locked() has checked it
    out.replaced_link = guest.link;
    out.reason = "session full: somebody who was here before has come back";
    disconnect(guest, out.reason);
  }
  if (same_process) {
    record->outgoing.go_on_after(theirs.received);
  } else {
    record->outgoing = {};
    record->last_received = 0;
  }
  record->seniority.arrive(record->member.key == member.key, ++arrivals_);
  record->since = now;
  record->incarnation = hello.incarnation;
  record->member = member;
  record->status.role = member.role;
  record->link = link;
  record->ticket = ticket;
  record->max_payload = std::min(hello.max_message_bytes, options_.max_message_bytes);
  record->wake_posted = false;
  record->budget = {};
  record->dropped = false;
  record->status.connected = true;
  record->status.reason.clear();
  ++connected_;
  return out;
}

void PeerTable::detach(std::uint64_t link, PeerId peer, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (Record* record = find_attached(link, peer)) disconnect(*record, reason);
}

void PeerTable::note_failure(PeerId peer, const std::string& reason, bool rejected) {
  const std::lock_guard lock(mutex_);
  Record* record = find_or_add(peer);
  if (record == nullptr) return;
  if (rejected) ++record->status.rejected;
  // A connected peer has no reason; the reason of a drop is not overwritten by its consequences.
  if (record->link == 0 && !record->dropped) record->status.reason = reason;
}

void PeerTable::expel(std::uint64_t link, PeerId peer, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return;
  disconnect(*record, reason);
  record->inbox.clear();
  record->outgoing.clear();
}

void PeerTable::reject(std::uint64_t link, PeerId peer, const std::string& reason, SteadyTime now) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return;
  ++record->status.rejected;
  ban(*record, "dropped: " + reason, now);
}

PeerTable::Delivered PeerTable::deliver(std::uint64_t link, PeerId peer, Delivery delivery,
                                        std::uint64_t sequence, std::span<const std::byte> bytes,
                                        SteadyTime now) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return Delivered::Stale;
  record->seniority.stay(nanoseconds(now) - nanoseconds(record->since));
  if (delivery == Delivery::Reliable) {
    if (sequence <= record->last_received) return Delivered::Ok;  // received before a reconnection
    if (sequence != record->last_received + 1) return Delivered::Gap;
  }
  if (!record->budget.admits(nanoseconds(now))) {
    ++record->status.over_budget;
    if (record->budget.abused()) return Delivered::Abused;
    // Reliable frames were in flight when reading stopped.
    if (delivery == Delivery::Newest) return Delivered::Ok;
  }
  record->budget.spend(bytes.size());
  const std::size_t room = options_.receive_queue_bytes - queue_cost(bytes.size());
  record->status.dropped_queue_full += record->inbox.shed_states(room);
  if (record->inbox.cost() > room) {
    ++record->status.dropped_queue_full;
    return delivery == Delivery::Newest ? Delivered::Ok : Delivered::Full;
  }
  record->inbox.push({.delivery = delivery,
                      .sequence = sequence,
                      .bytes = {bytes.begin(), bytes.end()},
                      .received = clock_.now()});
  if (delivery == Delivery::Reliable) record->last_received = sequence;
  ++record->status.packets_in;
  record->status.bytes_in += bytes.size();
  return Delivered::Ok;
}

void PeerTable::charge(std::uint64_t link, PeerId peer, SteadyTime now) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return;
  record->seniority.stay(nanoseconds(now) - nanoseconds(record->since));
  record->budget.spend(0);
}

bool PeerTable::may_read(std::uint64_t link, PeerId peer, SteadyTime now) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  return record == nullptr || record->budget.has(nanoseconds(now));
}

bool PeerTable::acknowledge(std::uint64_t link, PeerId peer, std::uint64_t sequence) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return true;
  if (!record->outgoing.has_written(sequence)) return false;
  record->outgoing.acknowledge(sequence);
  return true;
}

void PeerTable::take(std::uint64_t link, PeerId peer, std::size_t limit,
                     std::vector<std::byte>& out) {
  const std::lock_guard lock(mutex_);
  Record* record = find_attached(link, peer);
  if (record == nullptr) return;
  record->wake_posted = false;
  const auto write = [&](const QueuedFrame& frame) {
    const bool reliable = frame.delivery == Delivery::Reliable;
    if (shutting_down_ && !reliable) return false;
    append_frame(out, reliable ? FrameType::Reliable : FrameType::Newest,
                 [&](pbd::ByteWriter& writer) {
                   if (reliable) writer.u64(frame.sequence);
                   writer.bytes(frame.bytes);
                 });
    ++record->status.packets_out;
    record->status.bytes_out += frame.bytes.size();
    return true;
  };
  while (!record->outgoing.empty() && out.size() < limit) record->outgoing.write_next(write);
}

std::uint64_t PeerTable::link_of(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Record* record = find(peer);
  return record != nullptr ? record->link : 0;
}

bool PeerTable::wanted(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const Record* record = find(peer);
  return record == nullptr || (record->link == 0 && !record->dropped);
}

void PeerTable::begin_shutdown() {
  const std::lock_guard lock(mutex_);
  shutting_down_ = true;
}

// ---- under the lock ----

PeerTable::Record* PeerTable::find(PeerId peer) {
  const auto at = records_.find(peer);
  return at != records_.end() ? &at->second : nullptr;
}

const PeerTable::Record* PeerTable::find(PeerId peer) const {
  const auto at = records_.find(peer);
  return at != records_.end() ? &at->second : nullptr;
}

PeerTable::Record* PeerTable::find_attached(std::uint64_t link, PeerId peer) {
  Record* record = find(peer);
  return record != nullptr && record->link == link ? record : nullptr;
}

PeerTable::Record* PeerTable::find_or_add(PeerId peer) {
  if (Record* record = find(peer)) return record;
  if (records_.size() >= 4 * options_.max_peers && !make_room()) return nullptr;
  Record& record = records_[peer];
  record.status.id = peer;
  return &record;
}

PeerTable::Record* PeerTable::guest_in_place_of(PeerId peer, const Member& member) {
  return who_gives_way(records_, peer, member,
                       [](const Record& record) { return record.link != 0; });
}

/// Ids are free for a stranger, and a long-lived process meets many. Removed first: peers never
/// connected, then those that stayed briefly, then those absent for longest, and last those that
/// were dropped.
bool PeerTable::make_room() {
  auto oldest = records_.end();
  for (auto at = records_.begin(); at != records_.end(); ++at) {
    if (at->second.link != 0) continue;
    const auto age = [](const Record& r) {
      return std::tuple(r.dropped, r.seniority.stayed(), r.departure);
    };
    if (oldest == records_.end() || age(at->second) < age(oldest->second)) oldest = at;
  }
  if (oldest == records_.end()) return false;
  records_.erase(oldest);
  return true;
}

void PeerTable::disconnect(Record& record, const std::string& reason) {
  if (record.link != 0) {
    --connected_;
    record.departure = ++departures_;
  }
  record.link = 0;
  record.status.connected = false;
  record.status.reason = reason;
  record.outgoing.drop_states();
}

void PeerTable::ban(Record& record, const std::string& reason, SteadyTime now) {
  disconnect(record, reason);
  record.inbox.clear();
  record.dropped = true;
  record.hold_until = now + options_.drop_hold;
}

}  // namespace tandem::net
