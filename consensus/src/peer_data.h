// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <vector>

#include "common/ranges.h"
#include "common/session_time.h"
#include "input/acts.h"
#include "input/springs.h"
#include "members/shared_bodies.h"
#include "receive/inbox.h"
#include "replay/world_history.h"
#include "tandem/consensus/peer.h"

namespace tandem::consensus {

/// Data shared by the stages of one peer. It does not know the stages; each has a reference to it.
struct PeerData {
  PeerData(pbd::World& world_in, Transport& transport_in, const PeerOptions& options_in)
      : options(options_in),
        world(world_in),
        transport(transport_in),
        springs(world_in, options),
        history(to_ns(options_in.influence.max_age)),
        acts(world_in, history, options),
        inbox({.max_age = options_in.influence.max_age,
               .max_future = options_in.max_future,
               .plausibility = options_in.plausibility}),
        bodies(world_in) {}

  PeerId self() const { return transport.self(); }
  /// Report of another peer. Valid until one is added or removed.
  PeerReport& report_of(PeerId peer) {
    auto it = ranges::lower_bound(reports, peer, &PeerReport::peer);
    if (it == reports.end() || it->peer != peer) it = reports.insert(it, PeerReport{.peer = peer});
    return *it;
  }
  /// Whether the body's ownership can pass between peers.
  bool changes_hands(const SharedBody& shared) const {
    return options.coupling == Coupling::SingleOwner && !shared.def.owner.has_value();
  }
  /// Weight of this peer's own estimates, relative to 1 for an established peer: grows from 0 after
  /// the first step, so that a newcomer takes over the session's state before it counts.
  double confidence() const {
    if (options.authority_ramp <= 0.0) return 1.0;
    const double since = started == 0 ? 0.0 : seconds(now - started);
    return std::clamp(since / options.authority_ramp, 0.0, 1.0);
  }
  /// The share that this peer announces for its states of a body.
  double announced(const SharedBody& shared) const {
    if (changes_hands(shared)) return shared.tenure.owner == self() ? 1.0 : 0.0;
    if (shared.def.owner.has_value()) return shared.def.owner == self() ? 1.0 : 0.0;
    return confidence() * announced_share(options.influence, springs.holds_alone(shared.def.body),
                                          shared.initiative.strength() >= 1.0);
  }
  /// Whether targets go into the solver's pass. With Coupling::None those of owners do.
  bool in_pass() const {
    return options.coupling == Coupling::OnePass || options.coupling == Coupling::None;
  }

  PeerOptions options;
  pbd::World& world;
  Transport& transport;
  Springs springs;
  WorldHistory history;
  Acts acts;
  Inbox inbox;
  SharedBodies bodies;
  std::vector<PeerReport> reports;  ///< by peer
  PeerStats stats;
  SessionTime now = 0;      ///< ns, of the last call
  SessionTime started = 0;  ///< ns, end of the first step
  double step_dt = 1.0 / 60.0;
};

}  // namespace tandem::consensus
