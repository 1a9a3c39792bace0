// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scenes/scenario.h"
#include "session/actor.h"
#include "session/options.h"
#include "tandem/consensus/virtual_network.h"
#include "trace/peer_trace.h"

namespace tandem::demos {

/// All peers in this process, in virtual time over a virtual link, and their users. Events are
/// ordered by time, then ends of steps before beginnings, then peer: same options, same bits.
/// @par Thread safety  One object: one thread at a time.
class VirtualSession {
 public:
  /// Scenario and replay must outlive it.
  /// @param replay  what the users do; null: their script
  /// @throws std::invalid_argument where scenario or link refuse the options
  VirtualSession(const Scenario& scenario, const DemoOptions& options,
                 const std::vector<Input>* replay);

  /// Let the next thing happen, unless it is later than `end`.
  /// @return its time, ns; nothing where it is later
  std::optional<consensus::SessionTime> act(consensus::SessionTime end);
  /// The run is over: say so in its traces. No further calls of act().
  void close_traces();

  std::vector<Actor>& actors() { return actors_; }
  consensus::VirtualNetwork& network() { return network_; }

 private:
  consensus::VirtualNetwork network_;
  // They outlive the actors, who use them; null where nobody asks for them.
  std::vector<std::unique_ptr<PeerTrace>> traces_;
  std::vector<Actor> actors_;
};

}  // namespace tandem::demos
