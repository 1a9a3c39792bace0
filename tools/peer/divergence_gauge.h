// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <map>

#include "peer/recent_quantiles.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// Distance of other peers' copies from ours at the stamps of used states. States of bodies that
/// our user leads are unused, so those are measured only at the others.
/// @par Thread safety  One object: the thread of its peer.
class DivergenceGauge final : public consensus::PeerObserver {
 public:
  static constexpr std::size_t kMaxPeers = 64;

  void on_estimate(const consensus::EstimateEvent& event) override;

  void turn();
  void forget(consensus::PeerId peer) { of_peer_.erase(peer); }
  /// m, of all peers.
  const RecentQuantiles& all() const { return all_; }
  /// m; null if nothing was heard.
  const RecentQuantiles* of(consensus::PeerId peer) const;

 private:
  RecentQuantiles all_;
  std::map<consensus::PeerId, RecentQuantiles> of_peer_;
};

}  // namespace tandem::demos
