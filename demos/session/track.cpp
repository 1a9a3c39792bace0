// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/track.h"

#include <algorithm>
#include <cstdio>

namespace tandem::demos {

namespace {

/// m/s^2: a larger acceleration within a step is an impact.
constexpr double kHitAcceleration = 40.0;

/// m, the path between two samples: the cubic that matches both velocities, exact in free fall; at
/// an impact, two straight lines.
pbd::Vec3 way_at(const TrackSample& before, const TrackSample& after, double s, double dt) {
  const pbd::Vec3 way = after.position - before.position;
  const pbd::Vec3 change = after.velocity - before.velocity;
  if (change.norm() > kHitAcceleration * dt) {
    // The lines through both samples are nearest to each other at the impact.
    const double at =
        std::clamp((dt * after.velocity - way).dot(change) / (dt * change.squaredNorm()), 0.0, 1.0);
    const pbd::Vec3 from_before = at * dt * before.velocity;
    const pbd::Vec3 from_after = way - (1.0 - at) * dt * after.velocity;
    const pbd::Vec3 corner = 0.5 * (from_before + from_after);
    return s < at ? pbd::Vec3(s / at * corner)
                  : pbd::Vec3(way - (1.0 - s) / std::max(1.0 - at, 1e-9) * (way - corner));
  }
  const double bend = s * (1.0 - s);
  return s * way +
         bend * ((1.0 - s) * (dt * before.velocity - way) - s * (dt * after.velocity - way));
}

}  // namespace

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
  result.position += way_at(before, *after, s, 1e-9 * static_cast<double>(gap));
  result.orientation = before.orientation.slerp(s, after->orientation);
  result.speed += s * (after->speed - before.speed);
  result.velocity += s * (after->velocity - before.velocity);
  return result;
}

void PeerRecord::note_fault(double at, const std::string& text) {
  if (!fault.empty() || text.empty()) return;
  char when[64];
  std::snprintf(when, sizeof(when), "peer %llu, %.2f s: ", static_cast<unsigned long long>(id), at);
  fault = when + text;
}

}  // namespace tandem::demos
