// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Internal: where a user's hand may go from where it was.
#include "../../consensus/src/input/hand_track.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/catch.h"

namespace tandem::consensus::hand_track_test {
namespace {

using pbd::Vec3;

constexpr SessionTime kStart = 1'000'000'000'000;
constexpr double kFrame = 1.0 / 60.0;

SessionTime at(double s) { return kStart + static_cast<SessionTime>(std::llround(1e9 * s)); }

Vec3 carried(const HandTrack& track, double dt) { return track.motion().after(dt).position; }

TEST_CASE("hand track: a steady motion is found despite lost samples", "[consensus]") {
  const Vec3 v(-0.4, 0.9, 0.1);
  const auto path = [&](double t) { return Vec3(Vec3(1.0, 2.0, 3.0) + t * v); };
  const int lost = GENERATE(0, 2, 3);  // one of so many; 0 = none
  HandTrack track;
  for (int i = 0; i < 60; ++i) {
    if (lost != 0 && i % lost == 0) continue;
    track.add(at(i * kFrame), path(i * kFrame), Vec3(9.0, 9.0, 9.0));  // asked at first alone
  }
  const double newest = 1e-9 * static_cast<double>(track.newest() - kStart);
  CHECK((carried(track, 0.15) - path(newest + 0.15)).norm() < 1e-3);
  CHECK((track.motion().velocity - v).norm() < 5e-3);
}

TEST_CASE("hand filter: a motion goes on as its acceleration fades", "[consensus]") {
  const HandFilter::Motion motion{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 2.0, 0.0), Vec3(0.0, 0.0, 3.0)};
  const HandFilter::Motion at_once = motion.after(0.0);
  CHECK(at_once.position == motion.position);
  CHECK(at_once.velocity == motion.velocity);
  // By small steps.
  Vec3 x = motion.position;
  Vec3 v = motion.velocity;
  Vec3 a = motion.acceleration;
  constexpr int kSteps = 100'000;
  constexpr double kStep = 0.3 / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    x += kStep * v;
    v += kStep * a;
    a -= kStep / 0.2 * a;
  }
  CHECK((motion.after(0.3).position - x).norm() < 1e-5);
  CHECK((motion.after(0.3).velocity - v).norm() < 1e-5);
  // In two parts as in one.
  CHECK((motion.after(0.1).after(0.2).position - motion.after(0.3).position).norm() < 1e-12);
}

TEST_CASE("hand track: the first sample's velocity counts, and past samples are kept",
          "[consensus]") {
  HandTrack track;
  CHECK(track.empty());
  track.add(at(0.0), Vec3(0.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0));
  CHECK((carried(track, 0.1) - Vec3(0.1, 0.0, 0.0)).norm() < 1e-12);
  track.add(at(0.02), Vec3(0.02, 0.01, 0.0), Vec3(1.0, 1.0, 0.0));
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

/// Of a motion with tremor: its state, and matrices of rates, noise and moments.
using State = Eigen::Matrix<double, 5, 1>;
using Square = Eigen::Matrix<double, 5, 5>;

TEST_CASE("hand filter: it gives the expected motion for all positions together", "[consensus]") {
  // The same model, by another way: the moments of x' = A x + noise by small steps, and the most
  // probable motion from all places at once, by the rule for normal distributions.
  constexpr double kRate = 2.0 * std::numbers::pi * 10.0;
  constexpr double kTremor = 3e-4;
  Square rates = Square::Zero();
  rates(0, 1) = rates(1, 2) = rates(3, 4) = 1.0;
  rates(2, 2) = -1.0 / 0.2;
  rates(4, 3) = -kRate * kRate;
  rates(4, 4) = -2.0 * 0.15 * kRate;
  Square noise = Square::Zero();
  noise(2, 2) = 5.0;
  noise(4, 4) = 4.0 * 0.15 * kRate * kRate * kRate * kTremor * kTremor;
  constexpr int kSmall = 2000;
  const double step = kFrame / kSmall;
  // Moments at the first place: the hand is there, with tremor or without.
  Square moments = Square::Zero();
  moments(0, 0) = moments(3, 3) = kTremor * kTremor;
  moments(0, 3) = moments(3, 0) = -kTremor * kTremor;
  moments(1, 1) = 1.0;
  moments(2, 2) = 0.5;
  moments(4, 4) = kTremor * kTremor * kRate * kRate;
  constexpr int kPlaces = 14;
  std::vector<Square> of_frame = {moments};
  const Square small = Square::Identity() + step * rates;
  Square transition = Square::Identity();
  for (int i = 0; i < kSmall; ++i) transition = small * transition;
  for (int frame = 1; frame < kPlaces; ++frame) {
    for (int i = 0; i < kSmall; ++i) {
      moments = small * moments * small.transpose() + step * noise;
    }
    of_frame.push_back(moments);
  }
  State seen = State::Zero();
  seen(0) = seen(3) = 1.0;
  Eigen::MatrixXd of_places(kPlaces - 1, kPlaces - 1);
  Eigen::MatrixXd with_last(5, kPlaces - 1);
  for (int i = 1; i < kPlaces; ++i) {
    Square later = Square::Identity();
    for (int j = i; j < kPlaces; ++j) {
      const State to = later * of_frame[static_cast<std::size_t>(i)] * seen;
      of_places(i - 1, j - 1) = of_places(j - 1, i - 1) = seen.dot(to);
      if (j == kPlaces - 1) with_last.col(i - 1) = to;
      later = transition * later;
    }
  }
  const auto path = [](double t) { return 0.02 * std::sin(9.0 * t) + 3e-4 * std::sin(70.0 * t); };
  HandFilter filter(Vec3(path(0.0), 0.0, 0.0), Vec3::Zero());
  Eigen::VectorXd places(kPlaces - 1);
  for (int i = 1; i < kPlaces; ++i) {
    filter.add(kFrame, Vec3(path(i * kFrame), 0.0, 0.0), Vec3::Zero());
    places(i - 1) = path(i * kFrame);
  }
  const State expected = with_last * of_places.ldlt().solve(places);
  const HandFilter::Motion& motion = filter.motion();
  CHECK_THAT(motion.position.x(), Catch::WithinAbs(expected(0), 1e-5));
  CHECK_THAT(motion.velocity.x(), Catch::WithinAbs(expected(1), 1e-3));
  CHECK_THAT(motion.acceleration.x(), Catch::WithinAbs(expected(2), 0.02));
  // Which is something: the motion has 0.18 m/s at most, and 1.6 m/s^2.
  INFO(expected.transpose());
  CHECK(std::abs(expected(1)) > 0.05);
}

TEST_CASE("hand filter: its result is finite at any times", "[consensus]") {
  for (const double dt : {-1.0, 0.0, 1e-9, 1e-6, 1e-3, 0.05, 0.3, 0.31, 1e9}) {
    CAPTURE(dt);
    HandFilter filter(Vec3::Zero(), Vec3(1.0, 0.0, 0.0));
    for (int i = 0; i < 2000; ++i) {
      filter.add(dt, Vec3(i % 2, -0.5 * (i % 3), 1e-3 * i), Vec3::Zero());
    }
    CHECK(filter.motion().after(0.3).position.allFinite());
    CHECK(filter.motion().after(1e9).velocity.allFinite());
    // And finds its way back.
    for (int i = 0; i < 200; ++i) filter.add(kFrame, Vec3(1.0, 2.0, 3.0), Vec3::Zero());
    CHECK((filter.motion().after(0.1).position - Vec3(1.0, 2.0, 3.0)).norm() < 1e-3);
  }
}

TEST_CASE("hand track: tremor is not carried on, and movements are", "[consensus]") {
  const auto sine = [](double hz, double amplitude) {
    return [=](double t) {
      const double angle = 2.0 * std::numbers::pi * hz * t;
      return Vec3(amplitude * std::sin(angle), amplitude * std::cos(1.1 * angle), 0.0);
    };
  };
  const Missed tremor = missed(sine(10.0, 4e-4));
  CHECK(tremor.track < 0.6 * tremor.line);
  const Missed slow = missed(sine(0.5, 0.1));
  CHECK(slow.track < 0.6 * slow.line);
  const Missed quick = missed(sine(1.5, 0.1));
  CHECK(quick.track < quick.line);
}

}  // namespace
}  // namespace tandem::consensus::hand_track_test
