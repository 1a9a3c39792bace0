// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/hand_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/session_time.h"

namespace tandem::consensus {
namespace {

using pbd::Vec3;

/// s: in the long window most of a tremor of 8 to 12 Hz cancels out. Where the hand is off its
/// parabola by more than tremor (m, rms; some of it, and all) it moves quickly, and the short one
/// counts. Cubes at profile 5 (seeds 11 to 13): all p95 2.6 mm, 12 with the short one alone;
/// largest 179 mm, 227 with the long one alone. The room has 24 mm, and 15 with the short one
/// alone, but three times the jerk.
constexpr double kLong = 0.175;
constexpr double kShort = 0.11;
constexpr double kSomeOff = 0.8e-3;
constexpr double kAllOff = 1.6e-3;
/// A parabola through fewer points says nothing of what it misses.
constexpr std::size_t kFewest = 5;

}  // namespace

void HandTrack::add(SessionTime stamp, const Vec3& position, const Vec3& velocity) {
  if (count_ > 0 && stamp <= newest()) clear();
  samples_[end_] = {stamp, position, velocity};
  end_ = (end_ + 1) % kMaxSamples;
  count_ = std::min(count_ + 1, kMaxSamples);
  motion_ = {position, velocity, Vec3::Zero()};
  const double off = fit(kLong);
  const double quick = std::clamp((off - kSomeOff) / (kAllOff - kSomeOff), 0.0, 1.0);
  if (!(quick > 0.0)) return;
  const Motion slow = motion_;
  fit(kShort);
  motion_.position = slow.position + quick * (motion_.position - slow.position);
  motion_.velocity = slow.velocity + quick * (motion_.velocity - slow.velocity);
  motion_.acceleration = slow.acceleration + quick * (motion_.acceleration - slow.acceleration);
}

double HandTrack::fit(double window) {
  // Normal equations of a + b t + c t^2, t in windows from the newest sample.
  double s[5] = {};
  Vec3 m[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  double square = 0.0;
  const Vec3& here = sample(0).position;
  std::size_t used = 0;
  for (; used < count_; ++used) {
    const double t = seconds(sample(used).stamp - newest()) / window;
    if (t < -1.0) break;
    const Vec3 way = sample(used).position - here;
    square += way.squaredNorm();
    double power = 1.0;
    for (int k = 0; k < 5; ++k, power *= t) {
      s[k] += power;
      if (k < 3) m[k] += power * way;
    }
  }
  if (used < kFewest) return std::numeric_limits<double>::infinity();
  // By cofactors of the matrix [s0 s1 s2; s1 s2 s3; s2 s3 s4].
  const double c00 = s[2] * s[4] - s[3] * s[3];
  const double c01 = s[2] * s[3] - s[1] * s[4];
  const double c02 = s[1] * s[3] - s[2] * s[2];
  const double c11 = s[0] * s[4] - s[2] * s[2];
  const double c12 = s[1] * s[2] - s[0] * s[3];
  const double c22 = s[0] * s[2] - s[1] * s[1];
  const double inverse = 1.0 / (s[0] * c00 + s[1] * c01 + s[2] * c02);
  const Vec3 a = inverse * (c00 * m[0] + c01 * m[1] + c02 * m[2]);
  const Vec3 b = inverse * (c01 * m[0] + c11 * m[1] + c12 * m[2]);
  const Vec3 c = inverse * (c02 * m[0] + c12 * m[1] + c22 * m[2]);
  if (!(a.allFinite() && b.allFinite() && c.allFinite())) {
    return std::numeric_limits<double>::infinity();
  }
  motion_ = {here + a, b / window, 2.0 / (window * window) * c};
  const double missed = square - a.dot(m[0]) - b.dot(m[1]) - c.dot(m[2]);
  return std::sqrt(std::max(missed, 0.0) / static_cast<double>(used - 3));
}

HandTrack::Motion HandTrack::at(SessionTime time) const {
  for (std::size_t i = 0; i < count_; ++i) {
    const Sample& before = sample(i);
    if (before.stamp > time) continue;
    if (i == 0) return {before.position, before.velocity, Vec3::Zero()};
    const Sample& after = sample(i - 1);
    const double f =
        static_cast<double>(time - before.stamp) / static_cast<double>(after.stamp - before.stamp);
    return {before.position + f * (after.position - before.position),
            before.velocity + f * (after.velocity - before.velocity), Vec3::Zero()};
  }
  const Sample& first = sample(count_ - 1);
  return {first.position, first.velocity, Vec3::Zero()};
}

}  // namespace tandem::consensus
