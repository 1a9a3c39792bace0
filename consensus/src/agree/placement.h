// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "agree/estimates.h"
#include "agree/remote_states.h"
#include "input/activity.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Puts bodies where others have them, where nothing else brings copies together. A body that is
/// taken along by another may have been measured already; Agreement::aim() forgets that.
class Placement {
 public:
  Placement(PeerData& data, RemoteStates& remote, const Activity& activity)
      : data_(data), remote_(remote), activity_(activity) {}

  /// Put a body where it is said to be, whatever is in between.
  void place(SharedBody& shared, const pbd::BodyState& state);
  /// Put a body where the leader has it, the majority of several or the lower id, if nothing else
  /// helps.
  void give_way(SharedBody& shared, std::span<const Inbox::Received> newest,
                const Estimates& estimates, bool several);
  /// After a step of `dt` s: whether agreement was held up, and whether the body was put somewhere
  /// else since the last one.
  void note_step(SharedBody& shared, double dt) const;

 private:
  /// place() where copies are apart for good, with all that joints hold to it, and with what
  /// touches those and is apart as well: put back one by one they would be inside each other.
  void place_apart(SharedBody& shared, const pbd::BodyState& state, PeerId leader);
  void place_along(SharedBody& shared, std::span<const Inbox::Received> newest, PeerId leader,
                   bool always);
  /// What place_apart() takes along, into assembly_ and island_.
  void collect_island(std::uint32_t slot);
  bool jumps(const SharedBody& shared, const pbd::Correction& correction, double dt) const;

  PeerData& data_;
  RemoteStates& remote_;
  const Activity& activity_;
  std::vector<std::uint32_t> assembly_;  ///< slots of bodies that are placed together
  std::vector<std::uint32_t> island_;    ///< and of those that touch them
};

}  // namespace tandem::consensus
