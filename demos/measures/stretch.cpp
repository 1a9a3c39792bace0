// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/stretch.h"

#include <vector>

namespace tandem::demos {

Stretch stretch(std::span<const PeerRecord> peers, const EvaluationOptions& options) {
  std::vector<double> one, several;
  for (const PeerRecord& peer : peers) {
    for (const StretchSample& sample : peer.stretches) {
      int users = sample.users;
      for (const PeerRecord& other : peers) {
        if (&other == &peer || sample.body >= other.tracks.size()) continue;
        const auto there = other.tracks[sample.body].at(sample.time, options.max_gap);
        if (there) users += there->users;
      }
      (users > 1 ? several : one).push_back(sample.distance);
    }
  }
  return {distribution(one), distribution(several)};
}

}  // namespace tandem::demos
