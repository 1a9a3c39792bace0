// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/placement.h"

#include <algorithm>

#include "agree/votes.h"
#include "common/body_state.h"
#include "common/ranges.h"

namespace tandem::consensus {
namespace {

/// m: a body that moves this much further in a step than its velocity explains was placed, and is
/// announced as jumped (tests/consensus/jump_test.cpp: an owner's jump).
constexpr double kJump = 0.1;

/// A newcomer is placed again if the others correct its first state by more than this distance (m)
/// within this part of its authority ramp.
constexpr double kNewcomerPart = 0.3;
constexpr double kWrongPlace = 0.03;

}  // namespace

void Placement::place(SharedBody& shared, const pbd::BodyState& state) {
  data_.world.set_pose(shared.def.body, state.pose);
  data_.world.set_twist(shared.def.body, state.twist);
  data_.history.restart(shared.def.body.index, data_.world);
  ++shared.placed;
}

void Placement::give_way(SharedBody& shared, const Estimates& estimates) {
  if (!shared.joined || data_.confidence() >= kNewcomerPart || !estimates.leaders.empty()) return;
  const std::vector<Claim>& claims = estimates.claims;
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (!outvoted(claims, i, data_.self())) continue;
    const auto there = ranges::find(estimates.states, claims[i].peer, &PeerEstimate::peer);
    if (there == estimates.states.end() || claims[i].way.norm() <= kWrongPlace) return;
    return place(shared, {there->pose, there->twist});
  }
}

void Placement::note_step(SharedBody& shared, double dt) const {
  const bool in_pass = data_.in_pass();
  const pbd::Correction correction =
      in_pass ? data_.world.correction(shared.def.body) : shared.averaged;
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
