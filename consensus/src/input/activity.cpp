// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/activity.h"

#include <algorithm>

#include "tandem/pbd/contact.h"

namespace tandem::consensus {
void Activity::look() {
  mark_joints();
  mark_acting();
  spread_acting();
}

void Activity::look_at(SharedBody& shared, std::span<const Inbox::Received> newest) {
  note_grip(shared);
  update_initiative(shared, newest);
}

void Activity::mark_joints() {
  jointed_.assign(data_.world.slot_count(), 0);
  joined_.clear();
  edges_.clear();
  for (const auto& block : data_.world.blocks()) {
    if (block->order() < static_cast<int>(pbd::SolveOrder::Contact)) block->append_edges(edges_);
  }
  const auto moves = [&props = data_.world.all_props()](std::uint32_t slot) {
    return slot != pbd::BodyId::kNone && props[slot].type == pbd::BodyType::Dynamic;
  };
  for (const pbd::ConstraintEdge& edge : edges_) {
    if (edge.body_a != pbd::BodyId::kNone) jointed_[edge.body_a] = 1;
    if (edge.body_b != pbd::BodyId::kNone) jointed_[edge.body_b] = 1;
    if (moves(edge.body_a) && moves(edge.body_b)) joined_.emplace_back(edge.body_a, edge.body_b);
  }
}

void Activity::mark_acting() {
  const pbd::World& world = data_.world;
  acting_.assign(world.slot_count(), 0);
  data_.springs.mark(acting_);
  data_.acts.mark(kTouchedByOwn, kTouchedByOther, acting_);
  if (world.contacts() == nullptr && noted_contacts_.empty()) return;
  touching_.assign(world.slot_count(), 0);
  for (const SharedBody& shared : data_.bodies) {
    if (!data_.bodies.have_owners()) break;
    if (!shared.def.owner.has_value() || !world.contains(shared.def.body)) continue;
    touching_[shared.def.body.index] =
        shared.def.owner == data_.self() ? kTouchedByOwn : kTouchedByOther;
  }
  mark_noted_contacts();
  if (world.contacts() == nullptr) return;
  for (const pbd::Contact& contact : world.contacts()->contacts()) {
    // Over the whole step: a bounce is over by the last substep.
    if (!(contact.impulse > 0.0)) continue;
    const std::uint32_t a = contact.manifold.body_a;
    const std::uint32_t b = contact.manifold.body_b;
    acting_[a] = static_cast<std::uint8_t>(acting_[a] | kTouched | touching_[b]);
    acting_[b] = static_cast<std::uint8_t>(acting_[b] | kTouched | touching_[a]);
  }
}

void Activity::note_contact(pbd::BodyId a, pbd::BodyId b) {
  for (const auto& [body, other] : {std::pair(a, b), std::pair(b, a)}) {
    if (data_.world.contains(body)) noted_contacts_.emplace_back(body.index, other.index);
  }
}

void Activity::mark_noted_contacts() {
  for (const auto& [body, other] : noted_contacts_) {
    const std::uint8_t by = other < touching_.size() ? touching_[other] : std::uint8_t{0};
    if (body < acting_.size())
      acting_[body] = static_cast<std::uint8_t>(acting_[body] | kTouched | by);
  }
  noted_contacts_.clear();
}

void Activity::spread_acting() {
  constexpr std::uint8_t kOther = Springs::kRemote | kTouchedByOther | kJoinedToOther;
  const auto spread = [&](const std::pair<std::uint32_t, std::uint32_t>& pair) {
    std::uint8_t& a = acting_[pair.first];
    std::uint8_t& b = acting_[pair.second];
    if (((a | b) & kOther) == 0 || (a & b & kJoinedToOther) != 0) return false;
    a = static_cast<std::uint8_t>(a | kJoinedToOther);
    b = static_cast<std::uint8_t>(b | kJoinedToOther);
    return true;
  };
  // One pass each way covers a chain.
  for (bool more = true; more;) {
    more = false;
    for (auto it = joined_.begin(); it != joined_.end(); ++it) more = spread(*it) || more;
    for (auto it = joined_.rbegin(); more && it != joined_.rend(); ++it) spread(*it);
  }
}

void Activity::note_grip(SharedBody& shared) const {
  const std::uint32_t slot = shared.def.body.index;
  constexpr std::uint8_t kHeld = Springs::kShared | Springs::kAlone | Springs::kRemote;
  shared.held = (bits(slot) & kHeld) != 0;
  const bool jointed = slot < jointed_.size() && jointed_[slot] != 0;
  const bool touches = (bits(slot) & kTouched) != 0 || data_.world.in_contact(shared.def.body);
  shared.coupled = shared.held || jointed || touches;
}

void Activity::update_initiative(SharedBody& shared, std::span<const Inbox::Received> newest) {
  if (!data_.options.initiative || shared.def.owner.has_value()) return;
  const std::uint8_t acts = bits(shared.def.body.index);
  // A newcomer has not yet taken over the others' states.
  const bool established = data_.confidence() >= 1.0;
  Initiative::Acting acting{
      .own = established && (acts & (Springs::kShared | kTouchedByOwn)) != 0,
      .other = (acts & (Springs::kRemote | kTouchedByOther | kJoinedToOther)) != 0,
      .contact = shared.coupled};
  // A spring that only its own peer knows is covered by InfluenceOptions::held_alone.
  if ((acts & Springs::kAlone) != 0) acting.other = true;
  double round_trip = 0.0;
  const bool hands = trust_.believes_hands(newest.size());
  for (const Inbox::Received& received : newest) {
    if (received.update.flags.owner_driven && hands) acting.other = true;
    // A late peer does not delay listening to the others.
    if (!latecomers_.is_late(received.peer)) {
      round_trip = std::max(round_trip, 2.0 * seconds(received.arrival - received.update.stamp));
    }
    const bool leads = received.update.flags.leads &&
                       (newest.size() < 2 || trust_.believes_lead(shared, received.peer));
    shared.initiative.hear(received.peer, leads, received.update.stamp);
  }
  shared.initiative.update(acting, round_trip, data_.now);
}

}  // namespace tandem::consensus
