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
  /// @param replay  the users' inputs; null: their script
  /// @throws std::invalid_argument if scenario or link refuse the options
  VirtualSession(const Scenario& scenario, const DemoOptions& options,
                 const std::vector<Input>* replay);

  /// Runs the next event, unless it is later than `end`.
  /// @return its time, ns; nothing if it is later
  std::optional<consensus::SessionTime> act(consensus::SessionTime end);
  /// Ends the traces after the run. No further calls of act().
  void close_traces();

  std::vector<Actor>& actors() { return actors_; }
  consensus::VirtualNetwork& network() { return network_; }

 private:
  consensus::VirtualNetwork network_;
  // Before the actors that use them; null if not asked for.
  std::vector<std::unique_ptr<PeerTrace>> traces_;
  std::vector<Actor> actors_;
};

}  // namespace tandem::demos
