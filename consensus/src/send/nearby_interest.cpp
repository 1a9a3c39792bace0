// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/nearby_interest.h"

#include <algorithm>

#include "common/ranges.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
void NearbyInterestOptions::validate() const {
  pbd::detail::require_in(0.0, 1e7, "NearbyInterestOptions", "radius", radius, "m");
  pbd::detail::require_in(0.0, 1e7, "NearbyInterestOptions", "slack", slack, "m");
}

NearbyInterest::NearbyInterest(const pbd::World& world, Peer& peer,
                               const NearbyInterestOptions& options)
    : world_(world), peer_(peer), options_(options) {
  options_.validate();
  peer_.set_interest(this);
}

NearbyInterest::~NearbyInterest() { peer_.set_interest(nullptr); }

void NearbyInterest::set_position(PeerId user, const pbd::Vec3& position) {
  if (!position.allFinite()) {
    forget(user);
    return;
  }
  places_[user] = position;
  placed_.insert(user);
}

void NearbyInterest::forget(PeerId user) {
  places_.erase(user);
  placed_.erase(user);
  std::erase_if(told_, [user](const auto& entry) { return entry.first == user; });
}

void NearbyInterest::update() {
  held_.clear();
  involved_.clear();
  peer_.held_bodies(held_);
  if (held_.empty()) return;
  for (const HeldBody& each : held_) {
    involved_.emplace_back(each.user, each.body.index);
    if (!placed_.contains(each.user)) places_[each.user] = each.anchor_w;
  }
  edges_.clear();
  for (const auto& block : world_.blocks()) {
    if (block->order() < static_cast<int>(pbd::SolveOrder::Contact)) block->append_edges(edges_);
  }
  if (world_.contacts() != nullptr) {
    for (const pbd::Contact& contact : world_.contacts()->contacts()) {
      if (!(contact.impulse > 0.0)) continue;
      edges_.push_back({.body_a = contact.manifold.body_a, .body_b = contact.manifold.body_b});
    }
  }
  const auto add = [&](PeerId user, std::uint32_t slot) {
    if (slot != pbd::BodyId::kNone) involved_.emplace_back(user, slot);
  };
  for (const pbd::ConstraintEdge& edge : edges_) {
    for (const HeldBody& each : held_) {
      if (each.body.index == edge.body_a) add(each.user, edge.body_b);
      if (each.body.index == edge.body_b) add(each.user, edge.body_a);
    }
  }
  ranges::sort(involved_);
}

bool NearbyInterest::concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const {
  const auto place = places_.find(to);
  if (place == places_.end()) return true;
  const double apart = (pose.position - place->second).norm();
  const auto told = told_.find({to, id});
  const bool before = told != told_.end();
  if (apart <= options_.radius + (before ? options_.slack : 0.0)) {
    if (!before) told_.emplace(to, id);
    return true;
  }
  if (before) told_.erase(told);
  const pbd::BodyId body = peer_.body_of(id);
  return ranges::binary_search(involved_, Near(to, body.index));
}

}  // namespace tandem::consensus
