// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a replay costs: nothing where nobody differs, no more with many peers, and what the budget
// has.
#include <cmath>
#include <limits>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::replay_cost_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST_CASE("replay: a world at rest in agreement replays nothing", "[consensus]") {
  const bool sleeps = GENERATE(true, false);
  CAPTURE(sleeps);
  Session session(network_profile(5));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i);
    pbd::BodyDef def = cube({0.0, 0.0, kHalf.z()});
    def.can_sleep = sleeps;
    site.share(def);
    put_on_plane(site);
  }
  session.run(4.0);
  const ReplayStats before = session[0].peer->stats().replay;
  const std::uint64_t averaged = session[0].peer->stats().bodies_aggregated;
  session.run(4.0);
  const ReplayStats after = session[0].peer->stats().replay;
  CHECK(after.steps == before.steps);
  CHECK(after.fresh == before.fresh);
  CHECK(after.without == before.without);
  CHECK(after.seconds == before.seconds);
  // A body asleep at the same place everywhere is not even averaged, until one peer has it
  // elsewhere.
  CHECK((session[0].peer->stats().bodies_aggregated == averaged) == sleeps);
  session[1].displace({0.01, 0.0, 0.0});
  session.run(4.0);
  CHECK(session[0].peer->stats().bodies_aggregated > averaged);
  CHECK(gap(session[0], session[1]) < 1e-4);
}

TEST_CASE("replay: moving copies that agree need no replay", "[consensus]") {
  // States travel exactly here, and nothing acts on the ball.
  Session session({.latency = 8.0 * kFrame});
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, {.authority_ramp = 0.0}, kWeightless);
    site.share(ball(Vec3::Zero(), Vec3(1.0, 0.5, 0.0)));
  }
  session.run(3.0);
  CHECK(session[0].peer->stats().replay.steps == 0);
  CHECK(session[0].v() == Vec3(1.0, 0.5, 0.0));
}

/// Steps that the first of some peers replays in three seconds, all 8 frames from each other.
/// @param more  bodies beside the shared one, in free fall
ReplayStats replayed_among(int peers, const PeerOptions& options, int more = 0) {
  Session session({.latency = 8.0 * kFrame});
  for (int i = 0; i < peers; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options);
    pbd::BodyDef def = ball(Vec3(0.02 * i, 0.0, kBallRadius + 1.0 + 0.01 * i));
    def.can_sleep = false;
    site.share(def);
    put_ball_on_plane(site, 0.8);
    for (int k = 1; k <= more; ++k) {
      pbd::BodyDef other = ball(Vec3(2.0 * k + 0.02 * i, 0.0, 100.0));
      other.can_sleep = false;
      site.world.add_body(other);
    }
  }
  session.run(3.0);
  return session[0].peer->stats().replay;
}

TEST_CASE("replay: many peers cost one replay", "[consensus]") {
  const double budget = GENERATE(as<double>{}, kInf, ReplayOptions{}.budget);
  CAPTURE(budget);
  PeerOptions options{.authority_ramp = 0.0};
  options.replay.budget = budget;
  options.replay.tolerance = 0.0;  // they never agree so well that there is nothing to do
  const ReplayStats two = replayed_among(2, options);
  const ReplayStats nine = replayed_among(9, options);
  CHECK(two.steps > 100);
  CHECK(static_cast<double>(nine.steps) < 1.3 * static_cast<double>(two.steps));
  CHECK(static_cast<double>(nine.body_steps) < 1.3 * static_cast<double>(two.body_steps));
}

TEST_CASE("replay: no more is replayed than the budget has, and all of it without a limit",
          "[consensus]") {
  // The cost of a new replay is known: as many steps as the states are old. A few bodies are free.
  constexpr int kMany = 40;
  for (const double budget : {1.0, 1.75, 4.0, kInf}) {
    CAPTURE(budget);
    PeerOptions options{.authority_ramp = 0.0};
    options.replay.budget = budget;
    options.replay.tolerance = 0.0;
    const ReplayStats stats = replayed_among(2, options, kMany);
    const double steps = static_cast<double>(stats.steps) / 180.0;
    if (std::isinf(budget)) {
      CHECK(stats.postponed == 0);
      CHECK(steps > 7.0);
      CHECK(steps < 10.0);
    } else {
      CHECK(steps < budget + 0.1);
      CHECK(stats.postponed > 0);
    }
    CHECK(stats.fresh + stats.postponed + stats.without <= 180);
  }
}

TEST_CASE("replay: nor is more where news is now older and now newer", "[consensus]") {
  const double budget = GENERATE(1.5, 2.0, 4.0);
  CAPTURE(budget);
  constexpr int kMany = 40;
  PeerOptions options{.authority_ramp = 0.0};
  options.replay.budget = budget;
  options.replay.tolerance = 0.0;
  Session session({.latency = 8.0 * kFrame});
  for (int i = 0; i < 2; ++i) {
    // A peer whose packets come in bursts, as from a late machine, is heard six times a second.
    if (i == 1) options.update_hz = 6.0;
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options);
    pbd::BodyDef def = ball(Vec3(0.02 * i, 0.0, kBallRadius + 1.0));
    def.can_sleep = false;
    site.share(def);
    put_ball_on_plane(site, 0.8);
    for (int k = 1; k <= kMany; ++k) {
      pbd::BodyDef other = ball(Vec3(2.0 * k, 0.0, 100.0));
      other.can_sleep = false;
      site.world.add_body(other);
    }
  }
  session.run(5.0);
  const ReplayStats& stats = session[0].peer->stats().replay;
  CHECK(stats.fresh > 20);
  // One second's allowance may be saved up.
  CHECK(static_cast<double>(stats.steps) < budget * (300.0 + 60.0) + 10.0);
}

}  // namespace
}  // namespace tandem::consensus::replay_cost_test
