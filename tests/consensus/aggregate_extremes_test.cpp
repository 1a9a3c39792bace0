// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <vector>

#include "consensus/aggregate_fixture.h"
#include "support/catch.h"
#include "tandem/consensus/aggregate.h"

namespace aggregate_extremes_test {

using namespace tandem;
using namespace tandem::consensus;
using namespace tandem::consensus::testing;

TEST_CASE("aggregate: an owner overrides everybody", "[consensus][unit]") {
  Dice dice(9);
  const pbd::Pose local = some_pose(dice);
  auto estimates = around(dice, local, 4, 100.0 * kDegree, 0.9);
  estimates[2].share = 1.0;
  const PeerEstimate owner = estimates[2];
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  CHECK(target.share == 1.0);
  CHECK(target.pose.position == owner.pose.position);
  CHECK(target.twist.linear == owner.twist.linear);
  CHECK(angle_between(target.pose.orientation, owner.pose.orientation) == 0.0);
  CHECK(angle_between(applied(local, target), owner.pose.orientation) < 1e-14);
}

TEST_CASE("aggregate: two owners are met half way", "[consensus][analytic]") {
  Dice dice(10);
  const pbd::Pose local = some_pose(dice);
  auto estimates = around(dice, local, 3, 30.0 * kDegree, 0.9);
  const Vec3 turn = dice.direction() * 25.0 * kDegree;
  estimates[0].share = 1.0;
  estimates[2].share = 1.0;
  estimates[2].pose.orientation = turned(turn) * estimates[0].pose.orientation;
  const Vec3 middle = 0.5 * (estimates[0].pose.position + estimates[2].pose.position);
  const Quat half = turned(0.5 * turn) * estimates[0].pose.orientation;
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  CHECK(target.share == 1.0);
  CHECK((target.pose.position - middle).norm() < 1e-14);
  CHECK(angle_between(target.pose.orientation, half) < 1e-12);
  CHECK(angle_between(applied(local, target), half) < 1e-12);
}

TEST_CASE("aggregate: peers too far apart to be averaged: the heaviest decides the orientation",
          "[consensus][unit]") {
  const pbd::Pose local;
  std::vector<PeerEstimate> estimates(3);
  for (std::size_t i = 0; i < 3; ++i) {
    estimates[i].peer = i + 1;
    estimates[i].share = 0.1;
    estimates[i].pose.position = {static_cast<double>(i), 0.0, 0.0};
    estimates[i].pose.orientation =
        turned(Vec3(0.0, 0.0, (-40.0 + 40.0 * static_cast<double>(i)) * kDegree));
  }
  estimates[2].share = 0.2;
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  const double w = 0.25;  // of share 0.2
  const double t = 40.0 * kDegree;
  const double expected = std::atan2(w * std::sin(t), 1.0 + w * std::cos(t));
  CHECK((target.share * target.rotation_error - Vec3(0.0, 0.0, expected)).norm() < 1e-14);
  CHECK(angle_between(target.pose.orientation, estimates[2].pose.orientation) == 0.0);
  // Positions are averaged as ever: weights 1/9, 1/9, 1/4.
  const double x = (1.0 / 9.0 + 2.0 * 0.25) / (2.0 / 9.0 + 0.25);
  CHECK(target.pose.position.x() == Approx(x).epsilon(1e-14));

  // Among equals the lowest peer decides.
  estimates[2].share = 0.1;
  REQUIRE(fuse(local, estimates, target));
  CHECK(target.rotation_error.z() < 0.0);
}

TEST_CASE("aggregate: peers that agree are averaged however far the local state is",
          "[consensus][analytic]") {
  Dice dice(11);
  for (int round = 0; round < 200; ++round) {
    const pbd::Pose remote = some_pose(dice);
    auto estimates = around(dice, remote, 3, 30.0 * kDegree, 0.9);
    pbd::Pose local = remote;
    local.orientation =
        turned(dice.direction() * dice.uniform(60.0, 140.0) * kDegree) * remote.orientation;
    DenseMean all;
    all.add(local.orientation, 1.0);
    for (const PeerEstimate& e : estimates) all.add(e.pose.orientation, e.share / (1.0 - e.share));
    pbd::PoseTarget target;
    REQUIRE(fuse(local, estimates, target));
    CHECK(angle_between(applied(local, target), all.result()) < 1e-10);
  }
}

TEST_CASE("aggregate: peers that agree half a turn away are averaged among themselves",
          "[consensus][analytic]") {
  // 175 and 185 degrees about z: seen from here their quaternions lie on opposite half spheres, and
  // the sum of those would point at the local orientation.
  const pbd::Pose local;
  std::vector<PeerEstimate> estimates(2);
  for (std::size_t i = 0; i < 2; ++i) {
    estimates[i].peer = i + 1;
    estimates[i].share = 0.3;
    const double degrees = 175.0 + 10.0 * static_cast<double>(i);
    estimates[i].pose.orientation = turned(Vec3(0.0, 0.0, degrees * kDegree));
  }
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  CHECK(angle_between(target.pose.orientation, Quat(0.0, 0.0, 0.0, 1.0)) < 1e-12);
}

TEST_CASE("aggregate: where the average is open the local orientation stays", "[consensus][unit]") {
  const pbd::Pose local;
  std::vector<PeerEstimate> estimates(2);
  for (std::size_t i = 0; i < 2; ++i) {
    estimates[i].peer = i + 1;
    estimates[i].pose.orientation = Quat(0.0, 1.0, 0.0, 0.0);  // half a turn
    estimates[i].share = 1.0 / 3.0;                            // weights of a half
  }
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  CHECK(target.rotation_error.norm() == 0.0);
  estimates[0].share = 0.5;
  REQUIRE(fuse(local, std::span(estimates).first(1), target));
  CHECK(target.rotation_error.norm() == 0.0);
}

TEST_CASE("aggregate: nothing that counts leaves the target as it was", "[consensus][unit]") {
  pbd::PoseTarget target;
  target.share = 0.125;
  CHECK_FALSE(fuse(pbd::Pose{}, {}, target));
  std::vector<PeerEstimate> estimates(2);
  estimates[1].peer = 1;
  CHECK_FALSE(fuse(pbd::Pose{}, estimates, target));
  CHECK(target.share == 0.125);
  CHECK_FALSE(target.use_rotation_error);
}

TEST_CASE("aggregate: an estimate without a share has no say, wherever it is",
          "[consensus][unit]") {
  Dice dice(12);
  const pbd::Pose local = some_pose(dice);
  auto estimates = around(dice, local, 3, 10.0 * kDegree, 0.5);
  pbd::PoseTarget with;
  pbd::PoseTarget without;
  auto fewer = estimates;
  fewer.erase(fewer.begin() + 1);
  estimates[1].share = 0.0;
  estimates[1].pose.orientation = turned(Vec3(3.0, 0.0, 0.0)) * local.orientation;
  REQUIRE(fuse(local, estimates, with));
  REQUIRE(fuse(local, fewer, without));
  CHECK(with.pose.position == without.pose.position);
  CHECK(with.rotation_error == without.rotation_error);
}

}  // namespace aggregate_extremes_test
