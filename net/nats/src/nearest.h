// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/nats/nats_transport.h"

namespace tandem::nats {

/// The nearest of the near peers, up to a number, as all of them move. One of them is replaced only
/// by a peer nearer by `slack`, m.
class Nearest {
 public:
  Nearest(std::size_t most, double slack) : most_(most), slack_(slack) {}

  /// @return ascending; valid until the next call
  std::span<const consensus::PeerId> choose(std::span<const NearPeer> near, const pbd::Vec3& here) {
    ranked_.clear();
    for (const NearPeer& each : near) {
      const bool is_one = std::ranges::binary_search(chosen_, each.peer);
      const double apart = (each.position - here).head<2>().norm();
      ranked_.emplace_back(apart - (is_one ? slack_ : 0.0), each.peer);
    }
    std::ranges::sort(ranked_);
    if (ranked_.size() > most_) ranked_.resize(most_);
    chosen_.clear();
    for (const auto& [apart, peer] : ranked_) chosen_.push_back(peer);
    std::ranges::sort(chosen_);
    return chosen_;
  }

 private:
  std::size_t most_;
  double slack_;
  std::vector<consensus::PeerId> chosen_;
  std::vector<std::pair<double, consensus::PeerId>> ranked_;  ///< scratch
};

}  // namespace tandem::nats
