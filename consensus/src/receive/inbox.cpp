// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "receive/inbox.h"

#include <algorithm>

#include "common/ranges.h"
#include "common/session_time.h"

namespace tandem::consensus {
namespace {

/// ns: shortest time between jumps (UpdateFlags::teleported) that are believed. A state after a
/// silence of InboxOptions::max_age is not compared with the earlier one.
constexpr SessionTime kTeleportInterval = 200'000'000;

/// The entry with an id, of entries sorted by id; null if there is none.
template <class Entries, class Id>
auto* find(Entries& entries, const Id& id) {
  const auto at = ranges::lower_bound(entries, id, [](const auto& e) { return e.id; });
  return at != entries.end() && at->id == id ? &*at : nullptr;
}

}  // namespace

void Inbox::count(InboxCounters& counters, InboxVerdict verdict) {
  constexpr std::uint64_t InboxCounters::*kCounters[] = {
      &InboxCounters::accepted,   &InboxCounters::duplicate,   &InboxCounters::late,
      &InboxCounters::expired,    &InboxCounters::future,      &InboxCounters::implausible,
      &InboxCounters::unknown_id, &InboxCounters::unknown_peer};
  ++(counters.*kCounters[static_cast<std::size_t>(verdict)]);
}

std::uint64_t InboxCounters::dropped() const {
  return duplicate + late + expired + future + implausible + unknown_id + unknown_peer;
}

Inbox::Inbox(const InboxOptions& options)
    : max_age_ns_(to_ns(options.max_age)),
      max_future_ns_(to_ns(options.max_future)),
      plausibility_(options.plausibility) {}

void Inbox::add_id(const SharedId& id) {
  const auto at = ranges::lower_bound(bodies_, id, &Body::id);
  if (at != bodies_.end() && at->id == id) return;
  bodies_.insert(at, Body{.id = id});
}

void Inbox::remove_id(const SharedId& id) {
  std::erase_if(bodies_, [&](const Body& body) { return body.id == id; });
}

void Inbox::add_peer(PeerId peer) {
  auto at = ranges::lower_bound(peers_, peer, &Peer::id);
  if (at == peers_.end() || at->id != peer) at = peers_.insert(at, Peer{.id = peer});
  at->present = true;
}

void Inbox::remove_peer(PeerId peer) {
  Peer* const found = find(peers_, peer);
  if (found == nullptr) return;
  found->present = false;
  found->alive = 0;
  for (Body& body : bodies_) {
    std::erase_if(body.newest, [&](const Received& r) { return r.peer == peer; });
  }
}

void Inbox::forget_peer(PeerId peer) {
  remove_peer(peer);
  std::erase_if(peers_, [peer](const Peer& p) { return p.id == peer; });
}

InboxVerdict Inbox::offer(PeerId from, const StateUpdate& update, SessionTime now) {
  const InboxVerdict verdict = judge(from, update, now);
  count(totals_, verdict);
  if (Peer* const peer = find(peers_, from)) count(peer->counters, verdict);
  return verdict;
}

InboxVerdict Inbox::judge(PeerId from, const StateUpdate& update, SessionTime now) {
  const Peer* const peer = find(peers_, from);
  if (peer == nullptr || !peer->present) return InboxVerdict::UnknownPeer;
  const bool in_order = next_ < bodies_.size() && bodies_[next_].id == update.id;
  Body* const body = in_order ? &bodies_[next_] : find(bodies_, update.id);
  if (body == nullptr) return InboxVerdict::UnknownId;
  next_ = static_cast<std::size_t>(body - bodies_.data()) + 1;
  // Added on the side of the trusted clock: stamps at the end of the range must not overflow.
  if (update.stamp > now + max_future_ns_) return InboxVerdict::Future;
  // A resting body's state is sent once and may have waited long for a link.
  if (!update.flags.resting && update.stamp < now - max_age_ns_) return InboxVerdict::Expired;
  return store(*body, from, update, now);
}

InboxVerdict Inbox::store(Body& body, PeerId from, const StateUpdate& update, SessionTime now) {
  const auto at = ranges::lower_bound(body.newest, from, &Received::peer);
  if (at == body.newest.end() || at->peer != from) {
    if (!plausible(update, plausibility_)) return InboxVerdict::Implausible;
    body.newest.insert(at, Received{.peer = from, .update = update, .arrival = now});
    return InboxVerdict::Accepted;
  }
  if (update.stamp == at->update.stamp) return InboxVerdict::Duplicate;
  if (update.stamp < at->update.stamp) return InboxVerdict::Late;
  if (!plausible(at->update, update, plausibility_)) {
    const bool told = update.flags.teleported && plausible(update, plausibility_);
    const bool again = at->jumped != 0 && now - at->jumped < kTeleportInterval;
    if (!told || again) return InboxVerdict::Implausible;
    at->jumped = now;
  }
  at->update = update;
  at->arrival = now;
  return InboxVerdict::Accepted;
}

std::span<const Inbox::Received> Inbox::newest(const SharedId& id) const {
  const Body* const body = find(bodies_, id);
  if (body == nullptr) return {};
  return body->newest;
}

bool Inbox::note_alive(PeerId from, SessionTime stamp, SessionTime now) {
  Peer* const peer = find(peers_, from);
  if (peer == nullptr || !peer->present || stamp > now + max_future_ns_) return false;
  const bool was_silent = peer->alive != 0 && peer->alive < now - max_age_ns_;
  if (stamp <= peer->alive) return false;
  peer->alive = stamp;
  return was_silent;
}

SessionTime Inbox::holds_until(const Received& received) const {
  if (!received.update.flags.resting) return received.update.stamp;
  return std::max(received.update.stamp, alive(received.peer));
}

SessionTime Inbox::alive(PeerId from) const {
  const Peer* const peer = find(peers_, from);
  return peer == nullptr ? 0 : peer->alive;
}

std::size_t Inbox::prune(SessionTime now) {
  // The clock was set back: what was said with later stamps no longer holds.
  for (Peer& peer : peers_) {
    if (peer.alive > now + max_future_ns_) peer.alive = 0;
  }
  std::size_t dropped = 0;
  for (Body& body : bodies_) {
    dropped += std::erase_if(body.newest, [&](const Received& r) {
      return holds_until(r) < now - max_age_ns_ || r.update.stamp > now + max_future_ns_;
    });
  }
  return dropped;
}

InboxCounters Inbox::counters(PeerId peer) const {
  const Peer* const found = find(peers_, peer);
  return found == nullptr ? InboxCounters{} : found->counters;
}

}  // namespace tandem::consensus
