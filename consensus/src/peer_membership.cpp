// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who comes late is told how things are, and what has come apart for good is put together again.
#include <algorithm>

#include "peer_impl.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// m and rad: a neighbour that is further from where the leader has it goes along.
constexpr double kApart = 0.03;
constexpr double kTurned = 0.35;

void add_once(std::vector<std::uint32_t>& slots, std::uint32_t slot) {
  if (std::find(slots.begin(), slots.end(), slot) == slots.end()) slots.push_back(slot);
}

}  // namespace

void Peer::Impl::look_around() {
  company_ = transport_.peers();
  std::erase_if(newcomers_, [this](PeerId id) {
    return std::ranges::none_of(
        company_, [id](const PeerStatus& peer) { return peer.id == id && peer.connected; });
  });
  // Whoever comes back says its names again.
  std::erase_if(connected_, [this](PeerId id) {
    const auto at = std::ranges::lower_bound(company_, id, {}, &PeerStatus::id);
    if (at != company_.end() && at->id == id && at->connected) return false;
    names_.forget(id);
    return true;
  });
  for (const PeerStatus& peer : company_) {
    const auto at = std::lower_bound(connected_.begin(), connected_.end(), peer.id);
    const bool known = at != connected_.end() && *at == peer.id;
    if (peer.connected && !known) {
      // Who was there before the first states were sent hears those.
      if (has_sent_) newcomers_.push_back(peer.id);
      connected_.insert(at, peer.id);
    }
  }
}

void Peer::Impl::greet_newcomers() {
  has_sent_ = true;
  for (const PeerId to : newcomers_) {
    const auto tell = [&] { post_to(to, Delivery::Reliable); };
    collect_concerning(to);
    post_records(std::span<const StateUpdate>(concerning_), kStateBytes, Delivery::Reliable, tell);
    post_records(std::span<const SpringUpdate>(spring_states_), kSpringBytes, Delivery::Reliable,
                 tell);
  }
  newcomers_.clear();
}

void Peer::Impl::place_apart(Shared& shared, const pbd::BodyState& state, PeerId leader,
                             SessionTime now) {
  place(shared, state);
  shared.jumped = kJumpTold;
  ++stats_.bodies_placed;
  collect_island(shared.def.body.index);
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    Shared& other = shared_[i];
    if (&other == &shared || other.def.owner.has_value()) continue;
    if (!world_.contains(other.def.body)) continue;
    const std::uint32_t slot = other.def.body.index;
    const bool joint = std::find(assembly_.begin(), assembly_.end(), slot) != assembly_.end();
    const bool touches = std::find(island_.begin(), island_.end(), slot) != island_.end();
    if (!joint && !touches) continue;
    place_along(other, inbox_.newest_at(i), leader, joint, now);
  }
}

void Peer::Impl::collect_island(std::uint32_t slot) {
  assembly_.assign(1, slot);
  for (std::size_t done = 0; done < assembly_.size(); ++done) {
    for (const auto& [a, b] : joined_) {
      if (a == assembly_[done]) add_once(assembly_, b);
      if (b == assembly_[done]) add_once(assembly_, a);
    }
  }
  island_.clear();
  if (world_.contacts() == nullptr) return;
  for (const std::uint32_t part : assembly_) {
    for (const pbd::Contact& contact : world_.contacts()->contacts()) {
      if (!(contact.impulse > 0.0)) continue;
      if (contact.manifold.body_a == part) add_once(island_, contact.manifold.body_b);
      if (contact.manifold.body_b == part) add_once(island_, contact.manifold.body_a);
    }
  }
}

void Peer::Impl::place_along(Shared& shared, std::span<const Inbox::Received> newest, PeerId leader,
                             bool always, SessionTime now) {
  const auto sent = std::find_if(newest.begin(), newest.end(),
                                 [leader](const auto& r) { return r.peer == leader; });
  if (sent == newest.end()) return;
  if (!always && (shared.held || sent->update.flags.held)) return;
  const Prediction there = carry(shared, leader, sent->update, now);
  const bool apart = there.translation.norm() > kApart || there.rotation.norm() > kTurned;
  if (!always && !apart) return;
  const pbd::BodyState own = world_.state(shared.def.body);
  place(shared, moved(own, there));
  shared.jumped = kJumpTold;
  ++stats_.bodies_placed;
}

}  // namespace tandem::consensus
