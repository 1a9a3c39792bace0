// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/plausibility.h"

#include <cmath>

#include "consensus/random.h"
#include "receive/inbox.h"
#include "support/catch.h"

namespace tandem::consensus::plausibility_test {
namespace {

using pbd::Quat;
using pbd::Vec3;
using testing::Dice;

constexpr SessionTime kFrame = 16'666'667;
const SharedId kId = SharedId::from_name("body");

StateUpdate state(const Vec3& x, const Vec3& v, SessionTime stamp) {
  return {.id = kId, .pose = {x, Quat::Identity()}, .twist = {v, Vec3::Zero()}, .stamp = stamp};
}

TEST_CASE("plausible: flying, falling, bouncing, tumbling bodies, despite lost states",
          "[consensus]") {
  Dice dice(3);
  const PlausibilityOptions limits;
  for (int trial = 0; trial < 2000; ++trial) {
    // A ball in a box of 3 m, at up to 60 m/s: several hits between two states are possible.
    Vec3 x = dice.vec3(1.5);
    Vec3 v = dice.direction() * dice.uniform(0.0, 60.0);
    const auto frames = static_cast<SessionTime>(1 + dice.below(30));
    const StateUpdate last = state(x, v, 0);
    for (SessionTime i = 0; i < 100 * frames; ++i) {
      const double dt = 1e-11 * static_cast<double>(kFrame);
      v.z() -= 9.81 * dt;
      x += v * dt;
      for (int k = 0; k < 3; ++k) {
        if (std::abs(x[k]) > 1.5 && x[k] * v[k] > 0.0) v[k] = -v[k];
      }
    }
    CHECK(plausible(last, state(x, v, frames * kFrame), limits));
  }
}

TEST_CASE("plausible: no jump, no speed and no hit beyond its limit", "[consensus]") {
  const PlausibilityOptions limits;
  const StateUpdate last = state(Vec3::Zero(), Vec3::Zero(), 0);
  // jump for now and for one frame, and half of 1000 m/s^2 in its square.
  const double most = 2.0 * limits.jump + 0.5 * 1000.0 / 3600.0;
  CHECK(plausible(last, state({most - 1e-3, 0.0, 0.0}, Vec3::Zero(), kFrame), limits));
  CHECK_FALSE(plausible(last, state({most + 1e-3, 0.0, 0.0}, Vec3::Zero(), kFrame), limits));
  CHECK_FALSE(plausible(last, state(Vec3::Zero(), {150.0, 0.0, 0.0}, kFrame), limits));
  CHECK_FALSE(plausible(state(Vec3::Zero(), {201.0, 0.0, 0.0}, 0), limits));
  StateUpdate turned = state(Vec3::Zero(), Vec3::Zero(), kFrame);
  turned.pose.orientation = Quat(Eigen::AngleAxisd(2.0, Vec3::UnitX()));
  CHECK(plausible(last, turned, limits));
  turned.pose.orientation = Quat(Eigen::AngleAxisd(2.3, Vec3::UnitX()));
  CHECK_FALSE(plausible(last, turned, limits));
  turned.pose.orientation.coeffs() *= -1.0;  // the same orientation
  CHECK_FALSE(plausible(last, turned, limits));
}

TEST_CASE("plausible: a jump that is told of is believed, but not in every state", "[consensus]") {
  Inbox inbox;
  inbox.add_id(kId);
  inbox.add_peer(2);
  const auto offer = [&](double x, int frame, bool told) {
    StateUpdate update = state({x, 0.0, 0.0}, Vec3::Zero(), frame * kFrame);
    update.flags.teleported = told;
    return inbox.offer(2, update, frame * kFrame);
  };
  CHECK(offer(0.0, 1, false) == InboxVerdict::Accepted);
  CHECK(offer(50.0, 2, false) == InboxVerdict::Implausible);
  CHECK(offer(50.0, 3, true) == InboxVerdict::Accepted);
  CHECK(offer(50.0, 4, true) == InboxVerdict::Accepted);  // told again
  CHECK(offer(0.0, 5, true) == InboxVerdict::Implausible);
  CHECK(offer(50.0, 6, false) == InboxVerdict::Accepted);
  CHECK(offer(0.0, 16, true) == InboxVerdict::Accepted);
  CHECK(inbox.counters(2).implausible == 2);
  // After a silence it is not judged by what was before.
  inbox.prune(100 * kFrame);
  CHECK(offer(500.0, 100, false) == InboxVerdict::Accepted);
}

}  // namespace
}  // namespace tandem::consensus::plausibility_test
