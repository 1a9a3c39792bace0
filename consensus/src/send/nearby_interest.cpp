// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/nearby_interest.h"

#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/ranges.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

void NearbyInterestOptions::validate() const {
  pbd::detail::require_in(0.0, 1e7, "NearbyInterestOptions", "radius", radius, "m");
  pbd::detail::require_in(0.0, 1e7, "NearbyInterestOptions", "slack", slack, "m");
}

class __attribute__((visibility("hidden"))) NearbyInterest::Impl {
 public:
  using Near = std::pair<PeerId, std::uint32_t>;  ///< a user, and the slot of a body

  Impl(const pbd::World& world_in, Peer& peer_in, const NearbyInterestOptions& options_in)
      : world(world_in), peer(peer_in), options(options_in) {}

  const pbd::World& world;
  Peer& peer;
  NearbyInterestOptions options;
  std::map<PeerId, pbd::Vec3> places;
  std::set<PeerId> placed;  ///< set by set_position()
  std::vector<HeldBody> held;
  std::vector<pbd::ConstraintEdge> edges;  ///< of the last update(): joined or touching
  std::vector<Near> involved;              ///< held bodies and those touching them; sorted
  std::set<std::pair<PeerId, SharedId>> told;
};

NearbyInterest::NearbyInterest(const pbd::World& world, Peer& peer,
                               const NearbyInterestOptions& options) {
  options.validate();
  impl_ = std::make_unique<Impl>(world, peer, options);
  peer.set_interest(this);
}

NearbyInterest::~NearbyInterest() { impl_->peer.set_interest(nullptr); }

void NearbyInterest::set_position(PeerId user, const pbd::Vec3& position) {
  if (!position.allFinite()) {
    forget(user);
    return;
  }
  impl_->places[user] = position;
  impl_->placed.insert(user);
}

void NearbyInterest::forget(PeerId user) {
  impl_->places.erase(user);
  impl_->placed.erase(user);
  std::erase_if(impl_->told, [user](const auto& entry) { return entry.first == user; });
}

void NearbyInterest::update() {
  impl_->held.clear();
  impl_->involved.clear();
  impl_->peer.held_bodies(impl_->held);
  if (impl_->held.empty()) return;
  for (const HeldBody& each : impl_->held) {
    impl_->involved.emplace_back(each.user, each.body.index);
    if (!impl_->placed.contains(each.user)) impl_->places[each.user] = each.anchor_w;
  }
  impl_->edges.clear();
  for (const auto& block : impl_->world.blocks()) {
    if (block->order() < static_cast<int>(pbd::SolveOrder::Contact))
      block->append_edges(impl_->edges);
  }
  if (impl_->world.contacts() != nullptr) {
    for (const pbd::Contact& contact : impl_->world.contacts()->contacts()) {
      if (!(contact.impulse > 0.0)) continue;
      impl_->edges.push_back(
          {.body_a = contact.manifold.body_a, .body_b = contact.manifold.body_b});
    }
  }
  const auto add = [&](PeerId user, std::uint32_t slot) {
    if (slot != pbd::BodyId::kNone) impl_->involved.emplace_back(user, slot);
  };
  for (const pbd::ConstraintEdge& edge : impl_->edges) {
    for (const HeldBody& each : impl_->held) {
      if (each.body.index == edge.body_a) add(each.user, edge.body_b);
      if (each.body.index == edge.body_b) add(each.user, edge.body_a);
    }
  }
  ranges::sort(impl_->involved);
}

bool NearbyInterest::concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const {
  const auto place = impl_->places.find(to);
  if (place == impl_->places.end()) return true;
  const double apart = (pose.position - place->second).norm();
  const auto told = impl_->told.find({to, id});
  const bool before = told != impl_->told.end();
  if (apart <= impl_->options.radius + (before ? impl_->options.slack : 0.0)) {
    if (!before) impl_->told.emplace(to, id);
    return true;
  }
  if (before) impl_->told.erase(told);
  const pbd::BodyId body = impl_->peer.body_of(id);
  return ranges::binary_search(impl_->involved, Impl::Near(to, body.index));
}

}  // namespace tandem::consensus
