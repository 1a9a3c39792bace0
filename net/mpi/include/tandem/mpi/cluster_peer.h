// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "tandem/consensus/peer.h"
#include "tandem/mpi/cluster.h"
#include "tandem/pbd/export.h"

namespace tandem::mpi {

/// Shares bodies of a cluster with people. Each rank is a participant of the session, with a
/// transport and a peer id of its own, and speaks for the bodies that it owns: to the people the
/// ranks together are one more participant, whose copies lie in several places. A body that goes to
/// another rank is shared there from the next step on, and no longer where it was.
///
///     consensus::Peer peer(cluster.world(), transport);
///     ClusterPeer shared(cluster, peer);
///     shared.share(7, consensus::SharedId::from_name("crate"));  // all ranks alike
///     while (running) {
///       const consensus::SessionTime now = cluster.agree_on(clock());
///       shared.follow();
///       peer.before_step(now);
///       cluster.step(dt);
///       peer.after_step(now + dt_ns);
///     }
///
/// A rank's world cannot be copied, so that it guesses where others' copies are instead of
/// replaying them (consensus::PredictorKind). Hands of people pull at bodies where these are.
/// @par Thread safety  As Cluster.
class TANDEM_API ClusterPeer {
 public:
  /// Both outlive it. @param peer  of this rank, on the cluster's world
  ClusterPeer(Cluster& cluster, consensus::Peer& peer) : cluster_(cluster), peer_(peer) {}

  /// Share the dynamic body of a stable id, whichever rank has it.
  /// @throws std::invalid_argument where either is shared already or `id` names nothing
  void share(std::uint64_t stable_id, const consensus::SharedId& id);
  /// Before each step: share what has come to this rank, and no longer what has left it.
  void follow();

 private:
  struct Entry {
    std::uint64_t stable_id = 0;
    consensus::SharedId id;
    pbd::BodyId here;  ///< of this rank while it owns the body; else not valid
  };

  Cluster& cluster_;
  consensus::Peer& peer_;
  std::vector<Entry> entries_;
  std::set<std::uint64_t> stable_ids_;
  std::set<consensus::SharedId> ids_;
  std::optional<std::uint64_t> seen_;  ///< ClusterState::exchanged when all were looked at
};

}  // namespace tandem::mpi
