// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a peer leaves behind in its world.
#include <memory>
#include <utility>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::peer_lifetime_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;

TEST_CASE("peer lifetime: a peer that is gone leaves the world's blocks as it found them",
          "[consensus]") {
  StubTransport transport(1);
  pbd::World world(kWeightless);
  world.add_block<pbd::JointBlock>();  // it stays
  const pbd::BodyId held = world.add_body(ball(Vec3::Zero(), Vec3(0.1, 0.0, 0.0)));
  pbd::Solver solver{without_clock()};
  const auto run = [&] {
    for (int i = 0; i < 30; ++i) solver.step(world, kFrame);
    return world.hash();
  };
  const auto before = world.snapshot();
  const std::uint64_t expected = run();

  auto peer = std::make_unique<Peer>(world, transport, springs_only());
  peer->share({.id = kBody, .body = held});
  CHECK_THROWS_AS(world.restore(before), std::invalid_argument);  // it has one block more
  peer->before_step(kStart);
  peer->grab({.body = kBody, .anchor_w = Vec3(0.0, 0.0, 1.0)});
  transport.deliver(2, SpringUpdate{.spring = 7,
                                    .revision = 1,
                                    .event = SpringEvent::Create,
                                    .body = kBody,
                                    .anchor_w = Vec3(0.0, 1.0, 0.0),
                                    .stiffness = 100.0,
                                    .max_force = 10.0,
                                    .stamp = kStart});
  peer->before_step(kStart + ns(kFrame));
  solver.step(world, kFrame);
  peer.reset();
  // Both springs pulled, and neither does any more.
  const pbd::Twist twist = world.twist(held);
  CHECK(twist.linear.tail<2>().minCoeff() > 0.0);
  run();
  CHECK((world.twist(held).linear - twist.linear).norm() < 1e-12);

  world.restore(before);
  CHECK(run() == expected);
}

TEST_CASE("peer lifetime: bodies are shared and no longer shared within a step", "[consensus]") {
  // Ids below and above that of the body for which the step has a target: lists are made anew.
  Session session;
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, {.authority_ramp = 0.0}, kWeightless);
    site.share(ball(Vec3(0.1 * i, 0.0, 0.0)));
    site.coupled = [count = 0](Site& s, SessionTime) mutable {
      if (++count < 30 || count > 130) return;
      const SharedId below{kBody.high, kBody.low - 1};
      const SharedId above{kBody.high, kBody.low + static_cast<std::uint64_t>(count)};
      const Vec3 elsewhere(10.0 * count, 0.0, 0.0);
      if (count % 2 == 0) {
        s.peer->share({.id = below, .body = s.world.add_body(ball(elsewhere))});
      } else if (count > 30) {
        s.peer->unshare(below);
      }
      s.peer->share({.id = above, .body = s.world.add_body(ball(elsewhere + Vec3::UnitY()))});
    };
  }
  session.run(5.0);
  CHECK(gap(session[0], session[1]) < 1e-3);
  CHECK(session[0].x().x() == Approx(0.05).epsilon(0.01));
}

TEST_CASE("peer lifetime: a world that is moved away from its peer keeps its blocks",
          "[consensus][fault]") {
  StubTransport transport(1);
  pbd::World world(kWeightless);
  auto peer = std::make_unique<Peer>(world, transport, springs_only());
  const std::size_t blocks = world.blocks().size();
  const pbd::World elsewhere = std::move(world);
  peer.reset();
  CHECK(elsewhere.blocks().size() == blocks);
}

}  // namespace
}  // namespace tandem::consensus::peer_lifetime_test
