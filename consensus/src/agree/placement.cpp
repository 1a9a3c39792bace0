// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/placement.h"

#include <algorithm>

#include "agree/votes.h"
#include "common/body_state.h"
#include "common/ranges.h"
#include "tandem/pbd/contact.h"

namespace tandem::consensus {
namespace {

/// m and rad: a neighbour that is further from where the leader has it goes along.
constexpr double kApart = 0.03;
constexpr double kTurned = 0.35;

/// m: what moves so much further in a step than its velocity says was put there, and says so
/// (tests/consensus/jump_test.cpp: an owner's jump).
constexpr double kJump = 0.1;

/// Of what agreement asks for in a step: a body that does less is in something's way, and one that
/// does it is on its way, or between neighbours that it cannot both follow
/// (tests/consensus/jump_test.cpp).
constexpr double kBlocked = 0.5;

/// Part of the ramp of authority in which a newcomer is put elsewhere where others correct what it
/// was told first, and how far (m) that has to be.
constexpr double kNewcomerPart = 0.3;
constexpr double kWrongPlace = 0.03;

void add_once(std::vector<std::uint32_t>& slots, std::uint32_t slot) {
  if (std::find(slots.begin(), slots.end(), slot) == slots.end()) slots.push_back(slot);
}

}  // namespace

void Placement::place(SharedBody& shared, const pbd::BodyState& state) {
  data_.world.set_pose(shared.def.body, state.pose);
  data_.world.set_twist(shared.def.body, state.twist);
  data_.history.restart(shared.def.body.index, data_.world);
  ++shared.placed;
}

void Placement::give_way(SharedBody& shared, std::span<const Inbox::Received> newest,
                         const Estimates& estimates, bool several) {
  const std::vector<Claim>& claims = estimates.claims;
  const PeerId self = data_.self();
  const Claim* to = nullptr;
  for (std::size_t i = 0; i < claims.size() && to == nullptr; ++i) {
    const PeerId peer = claims[i].peer;
    const bool other = !estimates.leaders.empty() ? peer == estimates.leaders.front()
                       : several                  ? outvoted(claims, i, self)
                                                  : peer < self;
    if (other) to = &claims[i];
  }
  if (to == nullptr) return;
  const auto estimate = ranges::find(estimates.states, to->peer, &PeerEstimate::peer);
  if (estimate == estimates.states.end()) return;
  // A newcomer took over what it heard first, which may have been false.
  const bool newcomer = several && data_.confidence() < kNewcomerPart &&
                        estimates.leaders.empty() && to->way.norm() > kWrongPlace;
  if (newcomer && shared.joined) {
    place(shared, {estimate->pose, estimate->twist});
    return;
  }
  const auto sent = ranges::find(newest, to->peer, &Inbox::Received::peer);
  if (shared.held || sent->update.flags.held) return;
  if (!shared.arbiter.parted(to->way, to->turn, shared.blocked, data_.now)) return;
  place_apart(shared, {estimate->pose, estimate->twist}, to->peer);
}

void Placement::place_apart(SharedBody& shared, const pbd::BodyState& state, PeerId leader) {
  place(shared, state);
  shared.jumped = SharedBody::kJumpTold;
  ++data_.stats.bodies_placed;
  collect_island(shared.def.body.index);
  for (std::size_t i = 0; i < data_.bodies.size(); ++i) {
    SharedBody& other = data_.bodies[i];
    if (&other == &shared || other.def.owner.has_value()) continue;
    if (!data_.world.contains(other.def.body)) continue;
    const std::uint32_t slot = other.def.body.index;
    const bool joint = std::find(assembly_.begin(), assembly_.end(), slot) != assembly_.end();
    const bool touches = std::find(island_.begin(), island_.end(), slot) != island_.end();
    if (!joint && !touches) continue;
    place_along(other, data_.inbox.newest_at(i), leader, joint);
  }
}

void Placement::collect_island(std::uint32_t slot) {
  assembly_.assign(1, slot);
  for (std::size_t done = 0; done < assembly_.size(); ++done) {
    for (const auto& [a, b] : activity_.joined()) {
      if (a == assembly_[done]) add_once(assembly_, b);
      if (b == assembly_[done]) add_once(assembly_, a);
    }
  }
  island_.clear();
  if (data_.world.contacts() == nullptr) return;
  for (const std::uint32_t part : assembly_) {
    for (const pbd::Contact& contact : data_.world.contacts()->contacts()) {
      if (!(contact.impulse > 0.0)) continue;
      if (contact.manifold.body_a == part) add_once(island_, contact.manifold.body_b);
      if (contact.manifold.body_b == part) add_once(island_, contact.manifold.body_a);
    }
  }
}

void Placement::place_along(SharedBody& shared, std::span<const Inbox::Received> newest,
                            PeerId leader, bool always) {
  const auto sent = ranges::find(newest, leader, &Inbox::Received::peer);
  if (sent == newest.end()) return;
  if (!always && (shared.held || sent->update.flags.held)) return;
  const Prediction there = remote_.carry(shared, leader, sent->update);
  const bool apart = there.translation.norm() > kApart || there.rotation.norm() > kTurned;
  if (!always && !apart) return;
  const pbd::BodyState own = data_.world.state(shared.def.body);
  place(shared, moved(own, there));
  shared.jumped = SharedBody::kJumpTold;
  ++data_.stats.bodies_placed;
}

void Placement::note_step(SharedBody& shared, double dt) const {
  const bool in_pass = data_.in_pass();
  const pbd::Correction correction =
      in_pass ? data_.world.correction(shared.def.body) : shared.averaged;
  // Others set poses as they like.
  shared.blocked =
      !in_pass || correction.translation.dot(shared.asked) < kBlocked * shared.asked.squaredNorm();
  if (jumps(shared, correction, dt)) shared.jumped = SharedBody::kJumpTold;
  shared.averaged = {};
}

bool Placement::jumps(const SharedBody& shared, const pbd::Correction& correction,
                      double dt) const {
  const pbd::BodyState& state = data_.world.state(shared.def.body);
  if (!data_.history.knows(shared.def.body.index)) return false;
  const pbd::BodyState& last = data_.history.newest(shared.def.body.index);
  const double farthest =
      2.0 * dt * std::max(state.twist.linear.norm(), last.twist.linear.norm()) + kJump;
  const pbd::Vec3 way = state.pose.position - last.pose.position - correction.translation;
  return way.squaredNorm() > farthest * farthest;
}

}  // namespace tandem::consensus
