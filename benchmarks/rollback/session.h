// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rollback/rollback_peer.h"
#include "scenes/scenario.h"

namespace tandem::rollback_bench {

/// A run of any coupling, for comparison.
struct Run {
  std::vector<demos::PeerRecord> peers;
  std::vector<double> frame_ms;    ///< processor time of each peer's frames
  double steps_per_frame = 1.0;    ///< of the solver
  std::size_t stalled = 0;         ///< frames without a simulation
  std::size_t snapshot_bytes = 0;  ///< of the late peer
  std::size_t confirmed = 0;       ///< frames with all inputs known to all peers
  std::int64_t first_desync = -1;  ///< first one not confirmed alike; -1 = none
};

/// A demo's scene, smaller if it is heavy (cliff of 200 balls, pile of 8 x 8), or the table, where
/// all people act.
/// @param variant  as in the demos; "" = its default
/// @return null if there is no such name or variant
std::unique_ptr<demos::Scenario> make_scenario(const std::string& name, int people,
                                               const std::string& variant = "");

/// Rollback over the demos' virtual network. Afterwards one world simulates all inputs in order as
/// the reference of Run::first_desync.
Run run_rollback(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 const RollbackOptions& options);

/// The demo's own coupling over the same network, with equal starts as in rollback.
/// @param other_substeps  of the second peer; nullopt = as the others
/// @param join  frame at which the last peer asks to join; 0 = present from the start. It is
/// disconnected until its request arrives; its users act kJoinLead frames later.
Run run_coupling(const demos::Scenario& scenario, const demos::DemoOptions& demo,
                 std::optional<int> other_substeps, std::int64_t join);

}  // namespace tandem::rollback_bench
