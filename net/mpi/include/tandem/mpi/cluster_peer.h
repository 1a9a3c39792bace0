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

/// Shares bodies of a cluster with other peers. Each rank is a participant of the session, with its
/// own transport and peer id, and announces the bodies that it owns: to the other peers the ranks
/// together are one more participant. A body that migrates to another rank is shared there from the
/// next step on, and no longer where it was.
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
/// A rank's world cannot be copied, so it extrapolates others' states instead of replaying them
/// (consensus::PredictorKind). Users' springs pull at bodies on their owners.
/// @par Thread safety  As Cluster.
class TANDEM_API ClusterPeer {
 public:
  /// Both must outlive it. @param peer  of this rank, on the cluster's world
  ClusterPeer(Cluster& cluster, consensus::Peer& peer) : cluster_(cluster), peer_(peer) {}

  /// Share the dynamic body of a stable id, on whichever rank it is.
  /// @throws std::invalid_argument if either is shared already or `id` is zero
  void share(std::uint64_t stable_id, const consensus::SharedId& id);
  /// Call before each step: shares bodies that have come to this rank, and no longer those that
  /// have left.
  void follow();

 private:
  struct Entry {
    std::uint64_t stable_id = 0;
    consensus::SharedId id;
    pbd::BodyId here;  ///< on this rank while it owns the body; else invalid
  };

  Cluster& cluster_;
  consensus::Peer& peer_;
  std::vector<Entry> entries_;
  std::set<std::uint64_t> stable_ids_;
  std::set<consensus::SharedId> ids_;
  std::optional<std::uint64_t> seen_;  ///< ClusterState::exchanged at the last follow()
};

}  // namespace tandem::mpi
