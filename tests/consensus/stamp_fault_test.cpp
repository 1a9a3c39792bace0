// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Clocks that are ahead.
#include <algorithm>
#include <cmath>
#include <string>

#include "consensus/crowd_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::stamp_fault_test {
namespace {

using namespace testing;

TEST_CASE("peer: a peer that starts with its clock ahead counts in full 3 s later",
          "[consensus][fault]") {
  const double ahead = GENERATE(0.0, 10.0, 60.0, 30.0 * 86400.0, -3600.0);
  CAPTURE(ahead);
  Crowd crowd;
  crowd.build = [](Member& member) {
    pbd::BodyDef free = ball(Vec3::Zero());
    free.gravity_scale = 0.0;
    member.share("free", free);
  };
  crowd.add(1);
  Member& late = crowd.add(2);
  const SessionTime set_at = kStart + ns(1.9);
  late.clock = [&](SessionTime now) {
    return std::max<SessionTime>(1, now < set_at ? now + ns(ahead) : now);
  };
  crowd.run(3.0);
  // Weights decide where copies meet that were put apart at rest; nobody leads.
  late.world->set_pose(late.bodies[0].body, {Vec3(0.05, 0.0, 0.0), Quat::Identity()});
  crowd.run(2.0);
  CHECK(crowd[0].x(0).x() > 0.02);
  CHECK(crowd[0].x(0).x() < 0.03);
  CHECK(spread(crowd, 0) < 1e-3);
}

TEST_CASE("peer: a state stamped ahead lies on the same path, not ahead on it",
          "[consensus][fault]") {
  Crowd crowd;
  const Vec3 v(3.0, 0.0, 0.0);
  crowd.build = [&](Member& member) {
    pbd::BodyDef free = ball(Vec3::Zero(), v);
    free.gravity_scale = 0.0;
    member.share("free", free);
  };
  Member& member = crowd.add(2);
  Transport& other = crowd.network.transport(1);
  const SessionTime begins = kStart + ns(0.0011 * 2.0);
  crowd.tick = [&](SessionTime now) {
    if (now < kStart + ns(1.5)) return;
    const SessionTime stamp = now + ns(0.2);
    const StateUpdate update{
        .id = member.bodies[0].id,
        .pose = {1e-9 * static_cast<double>(stamp - begins) * v, Quat::Identity()},
        .twist = {v, Vec3::Zero()},
        .influence = 0.08F,
        .stamp = stamp};
    std::vector<std::byte> bytes;
    encode(std::span(&update, 1), bytes);
    other.post(2, bytes, Delivery::Newest);
  };
  double most = 0.0;
  crowd.after = [&](Member& m) {
    const Vec3 there = 1e-9 * static_cast<double>(m.told + ns(kTick) - begins) * v;
    most = std::max(most, (m.x(0) - there).norm());
  };
  crowd.run(4.0);
  CHECK(most < 1e-3);
}

}  // namespace
}  // namespace tandem::consensus::stamp_fault_test
