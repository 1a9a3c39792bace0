// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies that are not everybody's, and that come and go.
#include "consensus/peer_fixture.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::consensus::interest_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

TEST_CASE("peer: states outside a peer's interest are not sent, unshared ones are unknown",
          "[consensus]") {
  struct OnlyLeft final : Interest {
    bool concerns(PeerId, const SharedId&, const Pose& pose) const override {
      return pose.position.x() < 0.0;
    }
  };
  Session session;
  Site& a = session.add(1, 0.0, {}, kWeightless);
  Site& b = session.add(2, 0.0, {}, kWeightless);
  const OnlyLeft interest;
  a.peer->set_interest(&interest);
  a.share(ball(Vec3(-1.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0)));
  session.run(0.5);
  REQUIRE(b.peer->unknown().size() == 1);
  CHECK(b.peer->unknown()[0].from == 1);
  CHECK(b.peer->unknown()[0].update.id == kBody);
  CHECK(b.peer->unknown()[0].update.pose.position.x() == Approx(-0.5).margin(0.04));
  session.run(1.0);
  CHECK(b.peer->unknown().empty());
  CHECK_FALSE(b.peer->heard(kBody, 1).has_value());
}

TEST_CASE("peer: a body that is no longer shared is not sent, and its springs let go",
          "[consensus]") {
  Session session;
  Site& a = session.add(1, 0.0, {}, kWeightless);
  Site& b = session.add(2, 0.003, {}, kWeightless);
  for (Site* site : {&a, &b}) site->share(ball(Vec3::Zero()));
  b.peer->grab({.body = kBody, .anchor_w = Vec3(0.0, 0.0, 0.1)});
  session.run(0.5);
  CHECK(a.peer->held(kBody));
  CHECK(a.peer->heard(kBody, 2).has_value());
  a.peer->unshare(kBody);
  CHECK(a.tethers().size() == 0);
  CHECK(names(refusal([&] { a.peer->unshare(kBody); }), "id", kBody.to_string(), "shared"));
  const Vec3 left = a.x() + 0.1 * a.v();
  session.run(0.1);
  CHECK((a.x() - left).norm() < 2e-3);  // it flies on by itself
  CHECK_FALSE(a.peer->unknown().empty());
  CHECK_NOTHROW(a.peer->share({.id = kBody, .body = a.body}));
}

}  // namespace
}  // namespace tandem::consensus::interest_test
