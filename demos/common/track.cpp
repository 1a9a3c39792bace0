// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/track.h"

#include <algorithm>

namespace tandem::demos {

void Track::push(const TrackSample& sample) {
  if (!samples_.empty() && sample.time <= samples_.back().time) return;
  samples_.push_back(sample);
}

std::optional<TrackSample> Track::at(consensus::SessionTime time,
                                     consensus::SessionTime max_gap) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), time,
                       [](const TrackSample& s, consensus::SessionTime t) { return s.time < t; });
  if (after == samples_.end()) return std::nullopt;
  if (after->time == time) return *after;
  if (after == samples_.begin()) return std::nullopt;
  const TrackSample& before = *(after - 1);
  const consensus::SessionTime gap = after->time - before.time;
  if (gap > max_gap) return std::nullopt;
  const double s = static_cast<double>(time - before.time) / static_cast<double>(gap);
  TrackSample result = before;
  result.time = time;
  result.position += s * (after->position - before.position);
  result.orientation = before.orientation.slerp(s, after->orientation);
  result.speed += s * (after->speed - before.speed);
  result.velocity += s * (after->velocity - before.velocity);
  return result;
}

}  // namespace tandem::demos
