// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/summary.h"

#include <vector>

#include "common/ranges.h"
#include "tandem/consensus/aggregate.h"

namespace tandem::consensus {

std::optional<StateUpdate> fuse(std::span<const StateUpdate> states) {
  if (states.empty()) return std::nullopt;
  const StateUpdate& first = states.front();
  const bool leads = ranges::any_of(states, [](const auto& s) { return s.flags.leads; });
  StateUpdate out{.id = first.id, .stamp = first.stamp};
  out.flags.resting = true;
  std::vector<PeerEstimate> estimates;
  for (const StateUpdate& state : states) {
    if (state.id != first.id || state.stamp != first.stamp) return std::nullopt;
    if (leads && !state.flags.leads) continue;
    // Made-up ids: they only break ties if there is no mean.
    estimates.push_back({.peer = estimates.size() + 1,
                         .pose = state.pose,
                         .twist = state.twist,
                         .share = static_cast<double>(state.influence)});
    out.flags.in_contact = out.flags.in_contact || state.flags.in_contact;
    out.flags.held = out.flags.held || state.flags.held;
    out.flags.owner_driven = out.flags.owner_driven || state.flags.owner_driven;
    out.flags.teleported = out.flags.teleported || state.flags.teleported;
    out.flags.resting = out.flags.resting && state.flags.resting;
    out.oriented = out.oriented && state.oriented;
  }
  out.flags.leads = leads;
  pbd::PoseTarget target;
  if (!fuse(first.pose, estimates, target)) return std::nullopt;
  out.pose = target.pose;
  out.twist = target.twist;
  out.influence = static_cast<float>(target.share);
  return out;
}

}  // namespace tandem::consensus
