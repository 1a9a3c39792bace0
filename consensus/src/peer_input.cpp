// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who acts on which body, and what a hard input does to one.
#include <algorithm>
#include <cmath>

#include "peer_impl.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {

void Peer::Impl::mark_acting() {
  acting_.assign(world_.slot_count(), 0);
  springs_.mark(acting_);
  if (world_.contacts() == nullptr && noted_contacts_.empty()) return;
  touching_.assign(world_.slot_count(), 0);
  for (const Shared& shared : shared_) {
    if (owners_.empty()) break;
    if (!shared.def.owner.has_value() || !world_.contains(shared.def.body)) continue;
    touching_[shared.def.body.index] =
        shared.def.owner == transport_.self() ? kTouchedByOwn : kTouchedByOther;
  }
  mark_noted_contacts();
  if (world_.contacts() == nullptr) return;
  for (const pbd::Contact& contact : world_.contacts()->contacts()) {
    // Of the whole step: what bounced has left in the last substep.
    if (!(contact.impulse > 0.0)) continue;
    const std::uint32_t a = contact.manifold.body_a;
    const std::uint32_t b = contact.manifold.body_b;
    acting_[a] = static_cast<std::uint8_t>(acting_[a] | kTouched | touching_[b]);
    acting_[b] = static_cast<std::uint8_t>(acting_[b] | kTouched | touching_[a]);
  }
}

void Peer::Impl::note_contact(pbd::BodyId a, pbd::BodyId b) {
  for (const auto& [body, other] : {std::pair(a, b), std::pair(b, a)}) {
    if (world_.contains(body)) noted_contacts_.emplace_back(body.index, other.index);
  }
}

void Peer::Impl::mark_noted_contacts() {
  for (const auto& [body, other] : noted_contacts_) {
    const std::uint8_t by = other < touching_.size() ? touching_[other] : std::uint8_t{0};
    if (body < acting_.size())
      acting_[body] = static_cast<std::uint8_t>(acting_[body] | kTouched | by);
  }
  noted_contacts_.clear();
}

void Peer::Impl::spread_acting() {
  constexpr std::uint8_t kOther = Springs::kRemote | kTouchedByOther | kJoinedToOther;
  const auto spread = [&](const std::pair<std::uint32_t, std::uint32_t>& pair) {
    std::uint8_t& a = acting_[pair.first];
    std::uint8_t& b = acting_[pair.second];
    if (((a | b) & kOther) == 0 || (a & b & kJoinedToOther) != 0) return false;
    a = static_cast<std::uint8_t>(a | kJoinedToOther);
    b = static_cast<std::uint8_t>(b | kJoinedToOther);
    return true;
  };
  // Once up and once down is all that a chain takes.
  for (bool more = true; more;) {
    more = false;
    for (auto it = joined_.begin(); it != joined_.end(); ++it) more = spread(*it) || more;
    for (auto it = joined_.rbegin(); more && it != joined_.rend(); ++it) spread(*it);
  }
}

void Peer::Impl::update_initiative(Shared& shared, std::span<const Inbox::Received> newest,
                                   SessionTime now) {
  if (!options_.initiative || shared.def.owner.has_value()) return;
  const std::uint8_t bits = acting_[shared.def.body.index];
  // A newcomer has yet to take over what the others know.
  const bool established = confidence() >= 1.0;
  Initiative::Acting acting{
      .own = established && (bits & (Springs::kShared | kTouchedByOwn)) != 0,
      .other = (bits & (Springs::kRemote | kTouchedByOther | kJoinedToOther)) != 0,
      .contact = shared.coupled};
  // A spring that only its own peer knows has a rule of its own, raised_while_held_alone().
  if ((bits & Springs::kAlone) != 0) acting.other = true;
  double round_trip = 0.0;
  const bool hands = believes_hands(newest.size());
  for (const Inbox::Received& received : newest) {
    if (received.update.flags.owner_driven && hands) acting.other = true;
    round_trip = std::max(round_trip, 2.0 * seconds(received.arrival - received.update.stamp));
    const bool leads = received.update.flags.leads &&
                       (newest.size() < 2 || believes_lead(shared, received.peer, now));
    shared.initiative.hear(received.peer, leads, received.update.stamp);
  }
  shared.initiative.update(acting, round_trip, now);
}

bool Peer::Impl::hard_at_sender(const StateUpdate& update) const {
  return options_.mode == InputMode::Hard && update.flags.owner_driven && update.influence >= 1.0F;
}

bool Peer::Impl::drag(Shared& shared, SessionTime now) {
  hands_.clear();
  springs_.hands(shared.def.body, now, hands_);
  HardInput& hard = shared.hard;
  if (hands_.empty()) {
    hard.active = false;
    return false;
  }
  const pbd::BodyState last = hard.own;
  const pbd::BodyState& shown = world_.state(shared.def.body);
  hard.own.pose = dragged(world_.props(shared.def.body), shown.pose, hands_);
  if (!hard.active) {
    hard.own.twist = {};
  } else if (step_dt_ > 0.0) {
    // `last` is where the hand was going to be by now: what it missed is a change of velocity.
    const double part = 1.0 - std::exp(-step_dt_ / options_.anchor_velocity_filter);
    hard.own.twist.linear += part / step_dt_ * (hard.own.pose.position - last.pose.position);
    hard.own.twist.angular +=
        part / step_dt_ * pbd::rotation_between(last.pose.orientation, hard.own.pose.orientation);
  }
  hard.active = true;
  std::erase_if(estimates_, [](const PeerEstimate& estimate) { return estimate.share < 1.0; });
  hard.shown = hard.own;
  pbd::PoseTarget others;
  if (!estimates_.empty() && fuse(hard.own.pose, estimates_, others)) {
    const auto count = static_cast<double>(estimates_.size());
    hard.shown = moved(hard.own, gap(hard.own, {others.pose, others.twist}), count / (1.0 + count));
  }
  world_.set_pose(shared.def.body, hard.shown.pose);
  world_.set_twist(shared.def.body, hard.shown.twist);
  return true;
}

}  // namespace tandem::consensus
