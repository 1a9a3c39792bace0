// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/aggregate.h"

#include <cmath>
#include <vector>

#include "consensus/aggregate_fixture.h"
#include "support/catch.h"

namespace aggregate_test {

using namespace tandem;
using namespace tandem::consensus;
using namespace tandem::consensus::testing;

TEST_CASE("aggregate: positions and velocities are the weighted means of Eq. 1",
          "[consensus][analytic]") {
  Dice dice(1);
  for (int round = 0; round < 500; ++round) {
    const pbd::Pose local = some_pose(dice);
    auto estimates = around(dice, local, 1 + dice.below(8), 0.3, 0.95);
    Vec3 x_all = local.position;  // local weight 1
    Vec3 v = Vec3::Zero();
    Vec3 w = Vec3::Zero();
    double total = 0.0;
    for (const PeerEstimate& e : estimates) {
      const double weight = e.share / (1.0 - e.share);
      x_all += weight * e.pose.position;
      v += weight * e.twist.linear;
      w += weight * e.twist.angular;
      total += weight;
    }
    pbd::PoseTarget target;
    REQUIRE(fuse(local, estimates, target));
    const Vec3 x_new = local.position + target.share * (target.pose.position - local.position);
    CHECK((x_new - x_all / (1.0 + total)).norm() < 1e-12);
    CHECK((target.twist.linear - v / total).norm() < 1e-12);
    CHECK((target.twist.angular - w / total).norm() < 1e-12);
    CHECK(target.share == Approx(total / (1.0 + total)).epsilon(1e-14));
    CHECK(target.use_rotation_error);
  }
}

TEST_CASE("aggregate: rotations are the eigenvector average of Eq. 2, local state included",
          "[consensus][analytic]") {
  Dice dice(2);
  for (int round = 0; round < 4000; ++round) {
    const pbd::Pose local = some_pose(dice);
    const double spread = (round % 2 == 0 ? 20.0 : 60.0) * kDegree;
    // The second half with weights up to 1e6, the third quarter with tiny ones.
    const double max_share = round % 3 == 0 ? 0.999999 : (round % 3 == 1 ? 0.9 : 2e-3);
    auto estimates = around(dice, local, 2 + dice.below(6), spread, max_share);
    DenseMean all;
    DenseMean remote;
    all.add(local.orientation, 1.0);
    for (const PeerEstimate& e : estimates) {
      all.add(e.pose.orientation, e.share / (1.0 - e.share));
      remote.add(e.pose.orientation, e.share / (1.0 - e.share));
    }
    pbd::PoseTarget target;
    REQUIRE(fuse(local, estimates, target));
    CHECK(angle_between(applied(local, target), all.result()) < 1e-12);
    CHECK(angle_between(target.pose.orientation, remote.result()) < 1e-12);
    CHECK(std::abs(target.pose.orientation.norm() - 1.0) < 1e-14);
  }
}

TEST_CASE("aggregate: one peer turns the local state by atan2(W sin t, 1 + W cos t)",
          "[consensus][analytic]") {
  Dice dice(3);
  for (const double degrees : {1e-6, 0.1, 5.0, 30.0, 60.0, 90.0, 120.0, 170.0, 179.0}) {
    for (const double weight : {1e-6, 0.01, 0.1, 0.999, 1.0, 4.0, 1e3}) {
      const pbd::Pose local = some_pose(dice);
      const Vec3 axis = dice.direction();
      PeerEstimate e;
      e.peer = 1;
      e.share = weight / (1.0 + weight);
      const double t = degrees * kDegree;
      e.pose.orientation = turned(t * axis) * local.orientation;
      e.pose.orientation.coeffs() *= -1.0;
      pbd::PoseTarget target;
      REQUIRE(fuse(local, std::span(&e, 1), target));
      const double expected = std::atan2(weight * std::sin(t), 1.0 + weight * std::cos(t));
      INFO("angle " << degrees << " weight " << weight);
      CHECK((target.share * target.rotation_error - expected * axis).norm() < 1e-11);
    }
  }
}

TEST_CASE("aggregate: a strong peer far away asks for more than half a turn",
          "[consensus][analytic]") {
  // 170 degrees and W = 4: the exact answer is a turn by 166.8 degrees, of which the share is 0.8.
  const pbd::Pose local;
  PeerEstimate e;
  e.peer = 1;
  e.share = 0.8;
  e.pose.orientation = turned(Vec3(0.0, 0.0, 170.0 * kDegree));
  pbd::PoseTarget target;
  REQUIRE(fuse(local, std::span(&e, 1), target));
  CHECK(target.rotation_error.z() > 180.0 * kDegree);
  const double turn =
      std::atan2(4.0 * std::sin(170.0 * kDegree), 1.0 + 4.0 * std::cos(170.0 * kDegree));
  CHECK(target.share * target.rotation_error.z() == Approx(turn).epsilon(1e-12));
}

TEST_CASE("aggregate: a vanishing share keeps the direction to the target",
          "[consensus][analytic]") {
  // To first order in W the turn is W sum-weighted sin of the angles; relative to the share that
  // must not be lost to rounding, however small the share is.
  Dice dice(4);
  for (const double share : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    const pbd::Pose local = some_pose(dice);
    std::vector<PeerEstimate> estimates(2);
    const Vec3 axis = dice.direction();
    for (std::size_t i = 0; i < 2; ++i) {
      estimates[i].peer = i + 1;
      estimates[i].share = share;
      estimates[i].pose = local;
      estimates[i].pose.orientation =
          turned(0.1 * (1.0 + static_cast<double>(i)) * axis) * local.orientation;
    }
    pbd::PoseTarget target;
    REQUIRE(fuse(local, estimates, target));
    const double expected = 0.5 * (std::sin(0.1) + std::sin(0.2));
    CHECK((target.rotation_error - expected * axis).norm() < 5.0 * share + 1e-9);
  }
}

TEST_CASE("aggregate: a lone peer's estimate comes through bit for bit", "[consensus][unit]") {
  Dice dice(5);
  const pbd::Pose local = some_pose(dice);
  auto estimates = around(dice, local, 1, 0.5, 0.3);
  pbd::PoseTarget target;
  REQUIRE(fuse(local, estimates, target));
  CHECK(target.pose.position == estimates[0].pose.position);
  CHECK(target.twist.linear == estimates[0].twist.linear);
  CHECK(target.twist.angular == estimates[0].twist.angular);
  CHECK(target.pose.orientation.coeffs() == estimates[0].pose.orientation.coeffs());
}

TEST_CASE("aggregate: the order of the estimates does not change one bit", "[consensus][unit]") {
  Dice dice(6);
  for (const double spread : {5.0, 50.0, 150.0}) {
    const pbd::Pose local = some_pose(dice);
    auto estimates = around(dice, local, 7, spread * kDegree, 0.8);
    pbd::PoseTarget first;
    REQUIRE(fuse(local, estimates, first));
    for (int round = 0; round < 20; ++round) {
      for (std::size_t i = estimates.size(); i > 1; --i) {
        std::swap(estimates[i - 1], estimates[dice.below(i)]);
      }
      pbd::PoseTarget target;
      REQUIRE(fuse(local, estimates, target));
      CHECK(target.pose.position == first.pose.position);
      CHECK(target.pose.orientation.coeffs() == first.pose.orientation.coeffs());
      CHECK(target.rotation_error == first.rotation_error);
      CHECK(target.twist.linear == first.twist.linear);
      CHECK(target.share == first.share);
    }
  }
}

TEST_CASE("aggregate: equal peers that exchange states meet at the pairwise mean",
          "[consensus][analytic]") {
  // Both take weight 1 for the other: the same pose on both sides, half way.
  Dice dice(7);
  for (int round = 0; round < 200; ++round) {
    const pbd::Pose a = some_pose(dice);
    pbd::Pose b = a;
    b.position += dice.vec3(1.0);
    const Vec3 turn = dice.direction() * dice.uniform(0.0, 2.5);
    b.orientation = turned(turn) * a.orientation;
    const auto exchange = [](const pbd::Pose& local, const pbd::Pose& remote) {
      PeerEstimate e;
      e.peer = 1;
      e.pose = remote;
      e.share = 0.5;
      pbd::PoseTarget target;
      REQUIRE(fuse(local, std::span(&e, 1), target));
      pbd::Pose result;
      result.position = local.position + target.share * (target.pose.position - local.position);
      result.orientation = applied(local, target);
      return result;
    };
    const pbd::Pose at_a = exchange(a, b);
    const pbd::Pose at_b = exchange(b, a);
    CHECK((at_a.position - at_b.position).norm() < 1e-14);
    CHECK((at_a.position - 0.5 * (a.position + b.position)).norm() < 1e-14);
    CHECK(angle_between(at_a.orientation, at_b.orientation) < 1e-12);
    CHECK(angle_between(at_a.orientation, turned(0.5 * turn) * a.orientation) < 1e-12);
  }
}

TEST_CASE("aggregate: K peers that exchange with equal weights all find the same mean",
          "[consensus][analytic]") {
  Dice dice(8);
  for (const std::size_t count : {3u, 5u, 8u}) {
    std::vector<pbd::Pose> poses(count, some_pose(dice));
    Vec3 mean = Vec3::Zero();
    for (pbd::Pose& pose : poses) {
      pose.position += dice.vec3(1.0);
      pose.orientation = dice.rotation(15.0 * kDegree) * pose.orientation;
      mean += pose.position / static_cast<double>(count);
    }
    std::vector<Quat> found;
    for (std::size_t me = 0; me < count; ++me) {
      std::vector<PeerEstimate> estimates;
      for (std::size_t i = 0; i < count; ++i) {
        if (i == me) continue;
        PeerEstimate e;
        e.peer = i + 1;
        e.pose = poses[i];
        e.share = 0.5;
        estimates.push_back(e);
      }
      pbd::PoseTarget target;
      REQUIRE(fuse(poses[me], estimates, target));
      const Vec3 x =
          poses[me].position + target.share * (target.pose.position - poses[me].position);
      CHECK((x - mean).norm() < 1e-13);
      found.push_back(applied(poses[me], target));
    }
    for (const Quat& q : found) CHECK(angle_between(q, found.front()) < 1e-12);
  }
}

}  // namespace aggregate_test
