// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mpi/cluster_peer.h"

#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::mpi {

void ClusterPeer::share(std::uint64_t stable_id, const consensus::SharedId& id) {
  if (stable_id >= std::uint64_t{1} << 63) {
    pbd::detail::refuse("ClusterPeer::share: stable_id", "below 2^63", std::to_string(stable_id));
  }
  if (!id.valid()) {
    pbd::detail::refuse("ClusterPeer::share: id", "one that names something", id.to_string());
  }
  if (stable_ids_.contains(stable_id)) {
    pbd::detail::refuse("ClusterPeer::share: stable_id", "one that is not shared yet",
                        std::to_string(stable_id));
  }
  if (!ids_.insert(id).second) {
    pbd::detail::refuse("ClusterPeer::share: id", "one that is not used yet", id.to_string());
  }
  stable_ids_.insert(stable_id);
  entries_.push_back({.stable_id = stable_id, .id = id, .here = {}});
  seen_.reset();
}

void ClusterPeer::follow() {
  const std::uint64_t exchanged = cluster_.state().exchanged;
  if (seen_ == exchanged) return;
  seen_ = exchanged;
  for (Entry& entry : entries_) {
    const pbd::BodyId here = cluster_.own_body(entry.stable_id);
    if (here == entry.here) continue;
    if (entry.here.valid()) peer_.unshare(entry.id);
    if (here.valid()) peer_.share({.id = entry.id, .body = here});
    entry.here = here;
  }
}

}  // namespace tandem::mpi
