// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The ready-made rule of who is told of what.
#include "tandem/consensus/nearby_interest.h"

#include <limits>

#include "consensus/peer_fixture.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint_def.h"

namespace tandem::consensus::nearby_interest_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

const SharedId kOther = SharedId::from_name("other");

/// Peer 1 with the shared body at the origin; peer 2 is told, or not.
struct Pair {
  Pair() : a(session.add(1, 0.0, {}, kWeightless)), b(session.add(2, 0.0, {}, kWeightless)) {
    for (Site* site : {&a, &b}) site->share(ball(Vec3::Zero()));
    interest = std::make_unique<NearbyInterest>(a.world, *a.peer,
                                                NearbyInterestOptions{.radius = 2.0, .slack = 0.5});
    session.after = [this](Site& site) {
      if (site.id == 1) interest->update();
    };
  }
  bool tells(const Vec3& body) { return interest->concerns(2, kBody, {body, Quat::Identity()}); }

  Session session;
  Site& a;
  Site& b;
  std::unique_ptr<NearbyInterest> interest;
};

TEST_CASE("nearby interest: distance decides, with slack for bodies told before", "[consensus]") {
  Pair pair;
  CHECK(pair.tells(Vec3(100.0, 0.0, 0.0)));  // nobody knows where he is
  pair.interest->set_position(2, Vec3(1.0, 0.0, 0.0));
  CHECK_FALSE(pair.tells(Vec3(3.2, 0.0, 0.0)));
  CHECK(pair.tells(Vec3(2.9, 0.0, 0.0)));
  CHECK(pair.tells(Vec3(3.4, 0.0, 0.0)));
  CHECK_FALSE(pair.tells(Vec3(3.6, 0.0, 0.0)));
  CHECK_FALSE(pair.tells(Vec3(3.4, 0.0, 0.0)));
  pair.interest->set_position(2, Vec3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
  CHECK(pair.tells(Vec3(100.0, 0.0, 0.0)));
}

TEST_CASE("nearby interest: a held body goes to its user at any distance, who is there",
          "[consensus]") {
  Pair pair;
  pair.interest->set_position(2, Vec3(50.0, 0.0, 0.0));
  pair.session.run(0.3);
  CHECK_FALSE(pair.tells(Vec3::Zero()));
  const GrabId grab = pair.b.peer->grab({.body = kBody, .anchor_w = Vec3(0.0, 0.0, 0.1)});
  pair.session.run(0.3);
  CHECK(pair.tells(Vec3::Zero()));
  pair.b.peer->release(grab);
  pair.session.run(0.3);
  CHECK_FALSE(pair.tells(Vec3::Zero()));
  // Without a place of his own he is where his hand was.
  pair.interest->forget(2);
  pair.b.peer->grab({.body = kBody, .anchor_w = Vec3(0.0, 0.0, 0.1)});
  pair.session.run(0.3);
  pair.interest->forget(1);
  CHECK_FALSE(pair.interest->concerns(2, kOther, {Vec3(9.0, 0.0, 0.0), Quat::Identity()}));
  CHECK(pair.interest->concerns(2, kOther, {Vec3(1.0, 0.0, 0.0), Quat::Identity()}));
}

TEST_CASE("nearby interest: bodies joined to a held one go to its user as well", "[consensus]") {
  Pair pair;
  pair.interest->set_position(2, Vec3(50.0, 0.0, 0.0));
  const pbd::BodyId other = pair.a.world.add_body(ball(Vec3(1.0, 0.0, 0.0)));
  pair.a.peer->share({.id = kOther, .body = other});
  const auto tells = [&] { return pair.interest->concerns(2, kOther, pair.a.world.pose(other)); };
  pair.b.peer->grab({.body = kBody, .anchor_w = Vec3::Zero()});
  pair.session.run(0.3);
  CHECK_FALSE(tells());
  pair.a.world.add_block<pbd::JointBlock>().add(
      pair.a.world, pbd::ball_joint_at(pair.a.world, pair.a.body, other, Vec3(0.5, 0.0, 0.0)));
  pair.session.run(0.1);
  CHECK(tells());
}

TEST_CASE("nearby interest: options are refused by name, value and rule", "[consensus]") {
  Pair pair;
  CHECK(names(refusal([&] { NearbyInterest(pair.a.world, *pair.a.peer, {.radius = -1.0}); }),
              "radius", "-1", "0"));
}

}  // namespace
}  // namespace tandem::consensus::nearby_interest_test
