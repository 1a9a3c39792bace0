// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rollback/rollback_peer.h"
#include "scenes/scenario.h"

namespace tandem::rollback_bench {

/// A run of any coupling, as it is compared.
struct Run {
  std::vector<demos::PeerRecord> peers;
  std::vector<double> frame_ms;    ///< processor time of each peer's frames
  double steps_per_frame = 1.0;    ///< of the solver
  std::size_t stalled = 0;         ///< frames in which nothing could be simulated
  std::size_t snapshot_bytes = 0;  ///< of who came late
  std::size_t confirmed = 0;       ///< frames of which all peers know all inputs
  std::int64_t first_desync = -1;  ///< frame from which a peer's confirmed bits differ; -1 = none
};

/// A demo's scene, smaller where it is a heavy one (cliff of 200 balls, pile of 8 x 8), or the
/// table, where all people act.
/// @param variant  as of the demos; "" = its default
/// @return null where there is none of that name, or no such variant of it
std::unique_ptr<demos::Scenario> make_scenario(const std::string& name, int people,
                                               const std::string& variant = "");

/// Rollback over the demos' virtual network. Once it is over, one world simulates all inputs in
/// order: Run::first_desync is where any peer's confirmed frame differs from that.
Run run_rollback(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 const RollbackOptions& options);

/// The demo's own coupling over the same network. Copies start equal, as those of rollback must.
/// @param other_substeps  of the second peer; nullopt = as the others
/// @param join  frame at which the last peer asks to come in; 0 = it is there at once. Until it is
///   heard it is cut off from all, and its users act from kJoinLead frames later on.
Run run_coupling(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 std::optional<int> other_substeps, std::int64_t join);

}  // namespace tandem::rollback_bench
