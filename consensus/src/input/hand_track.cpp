// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/hand_track.h"

#include <algorithm>

#include "common/session_time.h"

namespace tandem::consensus {

using pbd::Vec3;

void HandTrack::add(SessionTime stamp, const Vec3& position, const Vec3& velocity) {
  if (count_ > 0 && stamp <= newest()) clear();
  filter_.add(count_ > 0 ? seconds(stamp - newest()) : 0.0, position, velocity);
  samples_[end_] = {stamp, {position, velocity}};
  end_ = (end_ + 1) % kMaxSamples;
  count_ = std::min(count_ + 1, kMaxSamples);
}

HandTrack::Place HandTrack::at(SessionTime time) const {
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& [stamp, before] = sample(i);
    if (stamp > time) continue;
    if (i == 0) return before;
    const auto& [next, after] = sample(i - 1);
    const double f = static_cast<double>(time - stamp) / static_cast<double>(next - stamp);
    return {before.position + f * (after.position - before.position),
            before.velocity + f * (after.velocity - before.velocity)};
  }
  return sample(count_ - 1).place;
}

}  // namespace tandem::consensus
