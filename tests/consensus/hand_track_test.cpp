// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Internal: where a user's hand may go from where it was.
#include "../../consensus/src/input/hand_track.h"

#include <cmath>
#include <numbers>

#include "support/catch.h"

namespace tandem::consensus::hand_track_test {
namespace {

using pbd::Vec3;

constexpr SessionTime kStart = 1'000'000'000'000;
constexpr double kFrame = 1.0 / 60.0;

SessionTime at(double s) { return kStart + static_cast<SessionTime>(std::llround(1e9 * s)); }

Vec3 carried(const HandTrack& track, double dt) {
  const HandTrack::Motion& m = track.motion();
  return m.position + dt * m.velocity + 0.5 * dt * dt * m.acceleration;
}

TEST_CASE("hand track: a parabola is found, whatever is lost of it", "[consensus]") {
  const Vec3 a(0.3, -1.2, 2.0);
  const Vec3 v(-0.4, 0.9, 0.1);
  const auto path = [&](double t) { return Vec3(Vec3(1.0, 2.0, 3.0) + t * v + 0.5 * t * t * a); };
  const int lost = GENERATE(0, 2, 3);  // one of so many; 0 = none
  HandTrack track;
  double t = 0.0;
  for (int i = 0; i < 40; ++i) {
    t = i * kFrame;
    if (lost != 0 && i % lost == 0) continue;
    track.add(at(t), path(t), Vec3(9.0, 9.0, 9.0));  // the velocity told is not asked
  }
  const double newest = 1e-9 * static_cast<double>(track.newest() - kStart);
  CHECK((carried(track, 0.15) - path(newest + 0.15)).norm() < 1e-6);
  CHECK((track.motion().acceleration - a).norm() < 1e-4);
}

TEST_CASE("hand track: of little the velocity told is taken, and of the past what was told",
          "[consensus]") {
  HandTrack track;
  CHECK(track.empty());
  track.add(at(0.0), Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0));
  track.add(at(0.02), Vec3(0.02, 0.01, 0.0), Vec3(1.0, 1.0, 0.0));
  CHECK((carried(track, 0.1) - Vec3(0.12, 0.11, 0.0)).norm() < 1e-12);
  CHECK((track.at(at(0.015)).position - Vec3(0.015, 0.0075, 0.0)).norm() < 1e-9);
  CHECK((track.at(at(0.015)).velocity - Vec3(1.0, 0.75, 0.0)).norm() < 1e-6);
  CHECK(track.at(at(-1.0)).position == Vec3::Zero());
  // A clock that goes back begins anew.
  track.add(at(-5.0), Vec3(7.0, 0.0, 0.0), Vec3::Zero());
  CHECK(track.at(at(0.0)).position == Vec3(7.0, 0.0, 0.0));
}

/// rms of what is missed 0.13 s ahead, m, for `f(t)`, and for the straight line of `velocity(t)`.
struct Missed {
  double track = 0.0;
  double line = 0.0;
};

template <class F>
Missed missed(const F& f) {
  HandTrack track;
  Missed sum;
  int count = 0;
  for (int i = 0; i < 600; ++i) {
    const double t = i * kFrame;
    const Vec3 velocity = (f(t) - f(t - kFrame)) / kFrame;
    track.add(at(t), f(t), velocity);
    if (i < 30) continue;
    sum.track += (carried(track, 0.13) - f(t + 0.13)).squaredNorm();
    sum.line += (f(t) + 0.13 * velocity - f(t + 0.13)).squaredNorm();
    ++count;
  }
  return {std::sqrt(sum.track / count), std::sqrt(sum.line / count)};
}

TEST_CASE("hand track: tremor is not carried on, and movements are", "[consensus]") {
  const auto sine = [](double hz, double amplitude) {
    return [=](double t) {
      const double angle = 2.0 * std::numbers::pi * hz * t;
      return Vec3(amplitude * std::sin(angle), amplitude * std::cos(1.1 * angle), 0.0);
    };
  };
  const Missed tremor = missed(sine(10.0, 4e-4));
  CHECK(tremor.track < 0.5 * tremor.line);
  const Missed slow = missed(sine(0.5, 0.1));
  CHECK(slow.track < 0.6 * slow.line);
  const Missed quick = missed(sine(1.5, 0.1));
  CHECK(quick.track < quick.line);
}

}  // namespace
}  // namespace tandem::consensus::hand_track_test
