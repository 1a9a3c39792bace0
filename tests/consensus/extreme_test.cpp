// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Disagreements that are large, lasting or of many; benchmarks/extreme looks at them over time.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "consensus/peer_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus::extreme_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;
const PeerOptions kAtOnce{.authority_ramp = 0.0};

/// m, largest distance between two copies.
double spread(const Session& session) {
  double most = 0.0;
  for (const auto& a : session.sites) {
    for (const auto& b : session.sites) most = std::max(most, gap(*a, *b));
  }
  return most;
}

/// Deepest overlap (m) with their walls over the last second of balls that a user at peer 1 draws
/// against one; peer 2 has it 10 cm nearer.
/// @param push_speed  m/s, see ContactOptions
double overlap_of_walls_apart(Coupling coupling, int profile, double push_speed) {
  constexpr double kWall = 0.5;
  constexpr double kNearer = 0.1;
  Session session(network_profile(profile));
  PeerOptions options = kAtOnce;
  options.coupling = coupling;
  options.two_step_thresholds = false;
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    pbd::SolverOptions solving = site.solver.options();
    solving.contact.push_speed = push_speed;
    site.solver = pbd::Solver(solving);
    site.share(ball(Vec3::Zero()));
    const pbd::BodyId wall = site.world.add_body({.type = pbd::BodyType::Static});
    site.contacts.ball_on_plane(wall, -Vec3::UnitX(), i * kNearer - kWall, site.body, kBallRadius,
                                {.friction = 0.5});
    site.world.set_contact_source(&site.contacts);
  }
  session[0].peer->grab(
      {.body = kBody, .anchor_w = Vec3(1.0, 0.0, 0.0), .stiffness = 500.0, .damping = 40.0});
  session.run(4.0);
  double deepest = 0.0;
  session.after = [&](Site& site) {
    const double wall = site.id == 2 ? kWall - kNearer : kWall;
    deepest = std::max(deepest, site.x().x() + kBallRadius - wall);
  };
  session.run(1.0);
  return deepest;
}

TEST_CASE("extreme: where one wall is nearer than the other, no copy is pushed into its own",
          "[consensus]") {
  constexpr double kSlow = 1.0;  // m/s
  for (const int profile : {1, 3, 5}) {
    for (const double push_speed : {kSlow, pbd::ContactOptions{}.push_speed}) {
      INFO("profile " << profile << ", overlaps opened at " << push_speed << " m/s");
      // Contacts come last in the pass: what is left is their tolerance.
      CHECK(overlap_of_walls_apart(Coupling::OnePass, profile, push_speed) < 1e-5);
    }
  }
  // Averaged first, a copy is set a share of 10 cm into the wall in each step. Where overlaps are
  // opened fast, the same step takes it out again.
  CHECK(overlap_of_walls_apart(Coupling::TwoStep, 1, kSlow) > 0.05 * 0.1);
}

TEST_CASE("extreme: without users, agreement never adds kinetic energy to all copies together",
          "[consensus]") {
  for (const int profile : {1, 3, 5}) {
    for (const int peers : {2, 4}) {
      Session session(network_profile(profile));
      double allowed = 0.0;
      for (int i = 0; i < peers; ++i) {
        Site& site = session.add(static_cast<PeerId>(i + 1), 0.003 * i, kAtOnce, kWeightless);
        site.share(ball(Vec3(0.05 * i, 0.0, 0.0), Vec3(0.5 * i - 0.5, 1.0 / (i + 1), 0.0)));
        site.world.set_twist(site.body, {site.v(), Vec3(0.0, 2.0 * i, 1.0)});
        allowed += site.world.kinetic_energy();
      }
      double most = 0.0;
      session.after = [&](Site&) {
        double sum = 0.0;
        for (const auto& site : session.sites) sum += site->world.kinetic_energy();
        most = std::max(most, sum);
      };
      session.run(4.0);
      INFO("profile " << profile << ", " << peers << " peers");
      // A weighted mean of velocities has no more energy than they have on average.
      CHECK(most <= allowed * (1.0 + 1e-9));
      CHECK(spread(session) < 0.05);
    }
  }
}

TEST_CASE("extreme: two peers that claim one body do not hear each other", "[consensus]") {
  Session session(network_profile(3));
  const Vec3 velocities[] = {{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, 3.0}};
  const PeerId owners[] = {1, 2, 2};  // the third takes the second's word
  for (std::size_t i = 0; i < 3; ++i) {
    session.add(i + 1, 0.0, kAtOnce, kWeightless)
        .share(ball(Vec3::Zero(), velocities[i]), owners[i]);
  }
  session.run(3.0);
  for (std::size_t i = 0; i < 2; ++i) {
    const double time = 1e-9 * static_cast<double>(session[i].world_time() - kStart);
    CHECK((session[i].x() - time * velocities[i]).norm() < 1e-6);
    CHECK((session[i].v() - velocities[i]).norm() < 1e-9);
  }
  CHECK(gap(session[1], session[2]) < 1e-6);
}

TEST_CASE("extreme: a peer that was frozen for two seconds comes back without a jolt",
          "[consensus]") {
  for (const int profile : {1, 5}) {
    Session session(network_profile(profile));
    const Vec3 velocity(1.0, 0.0, 0.0);
    double fastest = 0.0;
    for (const PeerId id : {1, 2}) {
      session.add(id, 0.0, {}, kWeightless).share(ball(Vec3::Zero(), velocity));
    }
    session.after = [&](Site& site) { fastest = std::max(fastest, site.v().norm()); };
    session.run(2.0);
    std::unique_ptr<Site> frozen = std::move(session.sites.back());
    session.sites.pop_back();
    session.run(2.0);
    frozen->steps += 120;
    session.sites.push_back(std::move(frozen));
    CHECK(gap(session[0], session[1]) == Approx(2.0).epsilon(0.02));
    session.run(3.0);
    INFO("profile " << profile);
    CHECK(gap(session[0], session[1]) < 1e-3);
    // All have the same velocity: there is nothing that could make them faster.
    CHECK(fastest < 1.0 + 1e-6);
    CHECK(session[0].v().norm() > 0.99);
  }
}

TEST_CASE("extreme: half a turn apart, copies come together and rest", "[consensus]") {
  for (const int profile : {1, 5}) {
    for (const Vec3& axis : {Vec3(0.0, 0.0, 1.0), Vec3(0.6, 0.0, 0.8)}) {
      Session session(network_profile(profile));
      for (int i = 0; i < 2; ++i) {
        session.add(static_cast<PeerId>(i + 1), 0.007 * i, kAtOnce, kWeightless)
            .share(cube(Vec3::Zero(), pbd::exp_map(axis * (std::numbers::pi * i))));
      }
      session.run(4.0);
      INFO("profile " << profile << ", axis " << axis.transpose());
      const Quat& a = session[0].pose().orientation;
      CHECK(a.angularDistance(session[1].pose().orientation) < 1e-3);
      for (const auto& site : session.sites) CHECK(site->twist().angular.norm() < 1e-6);
    }
  }
}

TEST_CASE("extreme: sixteen peers in a ring agree, though each hears its neighbours only",
          "[consensus]") {
  constexpr int kPeers = 16;
  constexpr double kApart = 0.1;
  Session session;
  PeerOptions options = kAtOnce;
  options.robust.outvote = false;  // who hears two of sixteen cannot tell who is far from the rest
  for (int i = 0; i < kPeers; ++i) {
    session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless)
        .share(ball(Vec3(kApart * i / (kPeers - 1), 0.0, 0.0)));
  }
  for (int a = 0; a < kPeers; ++a) {
    for (int b = 0; b < kPeers; ++b) {
      const int way = (b - a + kPeers) % kPeers;
      if (way == 0 || way == 1 || way == kPeers - 1) continue;
      session.network.cut(static_cast<PeerId>(a + 1), static_cast<PeerId>(b + 1));
    }
  }
  // Each step closes the part S = 2 w / (1 + 2 w) of the way to the mean of two neighbours, so that
  // the slowest wave loses S (1 - cos(2 pi / n)) of its height: diffusion.
  const double weight = weight_of_share(InfluenceOptions{}.baseline);
  const double loss =
      2.0 * weight / (1.0 + 2.0 * weight) * (1.0 - std::cos(2.0 * std::numbers::pi / kPeers));
  const double frames = std::log(100.0) / loss;
  session.run(0.2 * frames * kFrame);
  CHECK(spread(session) > 0.01 * kApart);
  // Twice as long, for what is taken off lest it be corrected twice.
  session.run(1.8 * frames * kFrame);
  CHECK(spread(session) < 0.01 * kApart);
}

}  // namespace
}  // namespace tandem::consensus::extreme_test
