// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/divergence_gauge.h"

namespace tandem::demos {

void DivergenceGauge::on_estimate(const consensus::EstimateEvent& event) {
  const pbd::Vec3 own = event.own.at_time(event.update.stamp).pose.position;
  const double distance = (event.update.pose.position - own).norm();
  all_.add(distance);
  const auto found = of_peer_.find(event.from);
  if (found != of_peer_.end()) {
    found->second.add(distance);
  } else if (of_peer_.size() < kMaxPeers) {
    of_peer_[event.from].add(distance);
  }
}

void DivergenceGauge::turn() {
  all_.turn();
  for (auto& [peer, quantiles] : of_peer_) quantiles.turn();
}

const RecentQuantiles* DivergenceGauge::of(consensus::PeerId peer) const {
  const auto found = of_peer_.find(peer);
  return found == of_peer_.end() ? nullptr : &found->second;
}

}  // namespace tandem::demos
