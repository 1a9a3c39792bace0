// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/hand.h"

#include <cmath>

#include "support/catch.h"

namespace tandem::demos::hand_test {
namespace {

using pbd::Vec3;

TEST_CASE("hand: minimum jerk begins and ends at rest and peaks at 1.875 d / T",
          "[demos][analytic]") {
  const Vec3 way(0.3, -0.4, 1.2);  // |way| = 1.3
  const double duration = 2.0;
  const HandPath path = HandPath(1.0, Vec3(1.0, 2.0, 3.0)).move_by(way, duration);
  REQUIRE((path.at(0.0) - Vec3(1.0, 2.0, 3.0)).norm() == 0.0);
  REQUIRE((path.at(1.0) - Vec3(1.0, 2.0, 3.0)).norm() == 0.0);
  REQUIRE((path.at(3.0) - (Vec3(1.0, 2.0, 3.0) + way)).norm() < 1e-15);
  REQUIRE((path.at(9.0) - (Vec3(1.0, 2.0, 3.0) + way)).norm() < 1e-15);
  REQUIRE((path.at(2.0) - (Vec3(1.0, 2.0, 3.0) + 0.5 * way)).norm() < 1e-15);

  const double h = 1e-4;
  const auto velocity = [&](double t) {
    return Vec3((path.at(t + h) - path.at(t - h)) / (2.0 * h));
  };
  const auto acceleration = [&](double t) {
    return Vec3((path.at(t + h) - 2.0 * path.at(t) + path.at(t - h)) / (h * h));
  };
  for (const double end : {1.0, 3.0}) {
    CHECK(velocity(end).norm() < 1e-6);
    // x''' = 60 d / T^3 just inside the ends, so the difference quotient sees about h of that.
    CHECK(acceleration(end).norm() < 60.0 * 1.3 / 8.0 * h);
  }
  double peak = 0.0;
  for (double t = 1.0; t <= 3.0; t += 1e-3) peak = std::max(peak, velocity(t).norm());
  CHECK(peak == Approx(1.875 * 1.3 / duration).epsilon(1e-5));
}

TEST_CASE("hand: a path waits where it is told and goes through its knots", "[demos][unit]") {
  HandPath path(0.0, Vec3::Zero());
  path.wait(0.5).move_by(Vec3(0.0, 0.0, 1.0), 1.0).wait(0.5).move_to(Vec3(5.0, 0.0, 0.0), 2.0);
  CHECK(path.end_time() == 4.0);
  CHECK(path.at(0.5).norm() == 0.0);
  CHECK(path.at(1.5) == Vec3(0.0, 0.0, 1.0));
  CHECK(path.at(1.9) == Vec3(0.0, 0.0, 1.0));
  CHECK(path.at(4.0) == Vec3(5.0, 0.0, 0.0));
}

TEST_CASE("hand: tremor keeps its bound and its rms, and lies between 8 and 12 Hz",
          "[demos][unit]") {
  for (const std::uint64_t seed : {1u, 2u, 77u}) {
    const double rms = 3e-4;
    const Tremor tremor(seed, rms);
    const int n = 100000;
    Vec3 squares = Vec3::Zero();
    Vec3 largest = Vec3::Zero();
    Eigen::Vector3i crossings = Eigen::Vector3i::Zero();
    Vec3 last = tremor.at(0.0);
    for (int i = 1; i <= n; ++i) {
      const Vec3 x = tremor.at(i * 1e-3);  // 100 s
      squares += x.cwiseProduct(x);
      largest = largest.cwiseMax(x.cwiseAbs());
      for (int k = 0; k < 3; ++k) crossings[k] += x[k] * last[k] < 0.0 ? 1 : 0;
      last = x;
    }
    for (int k = 0; k < 3; ++k) {
      CHECK(std::sqrt(squares[k] / n) == Approx(rms).epsilon(0.03));
      CHECK(largest[k] <= tremor.bound());
      // Two crossings in each period.
      CHECK(crossings[k] >= 2 * 8 * 100);
      CHECK(crossings[k] <= 2 * 12 * 100);
    }
    CHECK(tremor.at(3.0) == Tremor(seed, rms).at(3.0));
  }
  CHECK(Tremor(1, 3e-4).at(1.0) != Tremor(2, 3e-4).at(1.0));
}

TEST_CASE("hand: a move meets position, velocity and acceleration at both ends",
          "[demos][analytic]") {
  MinJerkMove::State from, to;
  from.position = Vec3(1.0, 2.0, 3.0);
  from.velocity = Vec3(0.5, -1.0, 0.0);
  from.acceleration = Vec3(2.0, 0.0, -3.0);
  to.position = Vec3(-1.0, 0.0, 4.0);
  to.velocity = Vec3(3.0, 0.25, -1.0);
  to.acceleration = Vec3(0.0, 5.0, 1.0);
  const MinJerkMove move(2.0, from, 2.75, to);
  const MinJerkMove::State start = move.at(2.0);
  CHECK((start.position - from.position).norm() < 1e-12);
  CHECK((start.velocity - from.velocity).norm() < 1e-12);
  CHECK((start.acceleration - from.acceleration).norm() < 1e-12);
  const MinJerkMove::State end = move.at(2.75 - 1e-9);
  CHECK((end.position - to.position).norm() < 1e-7);
  CHECK((end.velocity - to.velocity).norm() < 1e-6);
  CHECK((end.acceleration - to.acceleration).norm() < 1e-5);
  // Beyond the end it goes on evenly.
  CHECK((move.at(3.75).position - (to.position + to.velocity)).norm() < 1e-12);
  // From rest to rest it is min_jerk().
  MinJerkMove::State rest;
  rest.position = Vec3(1.0, 0.0, 0.0);
  const MinJerkMove plain(0.0, {}, 1.0, rest);
  CHECK(plain.at(0.3).position.x() == Approx(min_jerk(0.3)));
}

}  // namespace
}  // namespace tandem::demos::hand_test
