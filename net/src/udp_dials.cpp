// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "udp_dials.h"

#include <algorithm>
#include <utility>

namespace tandem::net {

namespace {

constexpr std::int64_t kToldLife = 30'000'000'000;  // ns, of an address after its last announcement
constexpr std::size_t kMaxTold = 64;                // dials
constexpr std::ptrdiff_t kMaxToldBy = 16;           // by one member
constexpr std::ptrdiff_t kMaxToldOf = 4;            // addresses of one peer

}  // namespace

void UdpDials::add_told(const KnownPeer& known, PeerId teller, std::int64_t now) {
  const auto same = std::ranges::find(dials_, known.address, &Dial::address);
  if (same != dials_.end()) {
    same->told_at = now;
    return;
  }
  const auto told_by = std::ranges::count_if(dials_, [&](const Dial& dial) {
    return dial.told_by == teller && !peers_.is_attached_directly(dial.peer);
  });
  const auto told_of = std::ranges::count(dials_, known.peer, &Dial::peer);
  if (peers_.is_attached_directly(known.peer) || told_by >= kMaxToldBy || told_of >= kMaxToldOf ||
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

void UdpDials::add_relayed(PeerId peer, std::int64_t now) {
  const UdpPeers::Record* record = peers_.record(peer);
  if (record != nullptr && (record->connection != nullptr || record->dropped)) return;
  const Address address = relayed_address(peer);
  if (std::ranges::find(dials_, address, &Dial::address) != dials_.end()) return;
  dials_.push_back({.address = address,
                    .peer = peer,
                    .due = now,
                    .backoff = options_.backoff_min,
                    .told_by = options_.handshake.self,
                    .told_at = now});
}

void UdpDials::forget_told(std::int64_t now) {
  std::erase_if(dials_, [&](const Dial& dial) {
    return dial.told_by != 0 && !dial.attempt && now - dial.told_at > kToldLife;
  });
}

void UdpDials::on_datagram(std::span<const std::byte> datagram, const Address& from,
                           std::int64_t now) {
  for (Dial& dial : dials_) {
    if (dial.address != from || !dial.attempt) continue;
    dial.attempt->on_datagram(datagram, now);
    finish(dial, now);
  }
}

void UdpDials::finish(Dial& dial, std::int64_t now) {
  using State = HandshakeInitiator::State;
  const State state = dial.attempt->state();
  if (state == State::Asking || state == State::Proving) return;
  const auto attempt = std::move(dial.attempt);
  dial.due = now + dial.backoff;
  dial.backoff = std::min(2 * dial.backoff, options_.backoff_max);
  if (state != State::Done) {
    // A successor refused because of its recently present predecessor is soon let in.
    if (state == State::Refused && attempt->verdict() == Verdict::Outdated) {
      dial.backoff = options_.backoff_min;
    }
    if (state == State::Refused) dial.peer = attempt->refused_by();
    peers_.note_failure(dial.peer, attempt->reason());
    return;
  }
  dial.attempts = 0;
  const Session& session = attempt->session();
  dial.peer = session.remote.peer;
  if (peers_.decide(session.remote, session.member, dial.address, now) != Verdict::Welcome) return;
  hooks_.established(session, dial.address);
}

bool UdpDials::is_wanted(const Dial& dial) const {
  if (peers_.is_leaving() || peers_.is_asked(dial.address)) return false;
  const UdpPeers::Record* record = peers_.record(dial.peer);
  if (record == nullptr) return true;
  if (record->dropped || !options_.handshake.stands(record->member)) return false;
  // A peer connected through a relay only, to which this is the direct path, is wanted too.
  return record->connection == nullptr ||
         (!is_relayed(dial.address) && !peers_.is_attached_directly(dial.peer));
}

void UdpDials::poll(Dial& dial, std::int64_t now) {
  if (!is_wanted(dial)) {
    dial.attempt.reset();
    return;
  }
  if (!dial.attempt) {
    if (now < dial.due) return;
    // Keys in turn: the dialled peer may not have the last change yet.
    const std::size_t key = dial.attempts++ % options_.handshake.key_count();
    dial.attempt = std::make_unique<HandshakeInitiator>(options_.handshake, random_,
                                                        hooks_.next_receiver(), now, key);
  }
  const auto datagram = dial.attempt->poll(now);
  if (!datagram.empty()) hooks_.send(datagram, dial.address);
  finish(dial, now);
}

void UdpDials::poll(std::int64_t now) {
  for (Dial& dial : dials_) poll(dial, now);
}

std::int64_t UdpDials::next_due(std::int64_t now) const {
  constexpr std::int64_t kHandshakeStep = 10'000'000;  // precision of its resends
  std::int64_t due = INT64_MAX;
  for (const Dial& dial : dials_) {
    if (!is_wanted(dial)) continue;
    due = std::min(due, dial.attempt ? now + kHandshakeStep : std::max(now, dial.due));
  }
  return due;
}

void UdpDials::on_attached(PeerId peer, const Address& address) {
  for (Dial& dial : dials_) {
    if (dial.address == address) dial.peer = peer;
    if (dial.peer == peer) dial.backoff = options_.backoff_min;
  }
}

void UdpDials::on_group_change() {
  for (Dial& dial : dials_) {
    dial.attempts = 0;
    dial.attempt.reset();
  }
}

bool UdpDials::has_promised(std::uint32_t receiver) const {
  return std::ranges::any_of(dials_, [receiver](const Dial& dial) {
    return dial.attempt && dial.attempt->receiver() == receiver;
  });
}

}  // namespace tandem::net
