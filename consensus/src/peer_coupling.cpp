// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Couplings other than the pass: what is done with the estimates before a plain step.
#include <algorithm>
#include <cmath>

#include "peer_impl.h"
#include "tandem/pbd/math.h"
#include "two_step.h"

namespace tandem::consensus {

PeerOptions with_published_rules(PeerOptions options) {
  options.predictor = PredictorKind::Euler;
  options.own_predictor = nullptr;
  options.prediction.extrapolates_orientation = false;
  options.influence.limits_guesses = false;
  options.initiative = false;
  options.arbitration = false;
  options.authority_ramp = 0.0;
  options.robust.outvote = false;
  return options;
}

void Peer::Impl::apply_coupling() {
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const pbd::PoseTarget& target = targets_[i];
    const bool thresholds = options_.coupling == Coupling::TwoStep && options_.two_step_thresholds;
    if (!thresholds && rests(world_, target, step_dt_, targeted_[i]->still)) continue;
    targeted_[i]->averaged = average_state(world_, target, step_dt_, options_.two_step_thresholds);
    history_.note_agreement(target.body.index, world_);
  }
}

std::optional<PeerId> Peer::Impl::owner(const SharedId& id) {
  const Shared& shared = at(id);
  if (ownership_ == nullptr || shared.def.owner.has_value()) return shared.def.owner;
  const PeerId owner = ownership_->owner(index_of(shared));
  return owner != 0 ? std::optional(owner) : std::nullopt;
}

void Peer::Impl::hear_ownership(PeerId from, SessionTime now) {
  if (ownership_ == nullptr) return;
  for (const OwnershipUpdate& update : incoming_.ownership) {
    if (const Shared* shared = find(update.body)) {
      ownership_->hear(index_of(*shared), from, update, now);
    } else {
      ++stats_.unknown_ids;
    }
  }
}

void Peer::Impl::update_ownership(SessionTime now) {
  PeerId lowest = 0;  // of those present; asked for once, and only where it matters
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    const Shared& shared = shared_[i];
    if (shared.def.owner.has_value() || !world_.contains(shared.def.body)) continue;
    const bool known = shared.def.body.index < acting_.size();
    const std::uint8_t bits = known ? acting_[shared.def.body.index] : std::uint8_t{0};
    const bool acting = (bits & (Springs::kShared | Springs::kAlone | kTouchedByOwn)) != 0;
    ownership_->update(i, shared.def.id, inbox_.newest_at(i), acting, now);
    if (!ownership_->abandoned(i, now)) continue;
    if (lowest == 0) {
      look_around();
      lowest = transport_.self();
      if (!connected_.empty()) lowest = std::min(lowest, connected_.front());
    }
    if (lowest == transport_.self()) ownership_->claim(i, now);
  }
  if (!ownership_->outgoing().empty()) look_around();
  for (const OwnershipUpdate& update : ownership_->outgoing()) {
    outgoing_.clear();
    encode(std::span<const OwnershipUpdate>(&update, 1), outgoing_);
    if (update.event == OwnershipEvent::Grant) {
      post_all(Delivery::Reliable);
    } else if (transport_.post(update.to, outgoing_, Delivery::Reliable)) {
      stats_.bytes_sent += outgoing_.size();
    }
  }
  ownership_->outgoing().clear();
}

void Peer::Impl::estimate_owner(Shared& shared, std::span<const Inbox::Received> newest,
                                SessionTime now) {
  const PeerId owner = ownership_->owner(index_of(shared));
  if (owner == 0 || owner == transport_.self()) return;
  const pbd::BodyState& own = world_.state(shared.def.body);
  for (const Inbox::Received& received : newest) {
    const StateUpdate& update = as_meant(received, shared);
    // Until the new owner has the grant nobody owns the body, and it moves as it does here.
    if (received.peer != owner || update.influence < 1.0F) continue;
    const Prediction prediction = carry(shared, owner, update, now);
    const pbd::BodyState there = moved(own, prediction);
    estimates_.push_back({.peer = owner, .pose = there.pose, .twist = there.twist, .share = 1.0});
    observe(shared, owner, update, prediction, now);
    return;
  }
}

}  // namespace tandem::consensus
