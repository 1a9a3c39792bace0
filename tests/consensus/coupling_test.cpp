// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What one-pass is compared with: two steps as published, none.
#include <cmath>

#include "../../demos/session/published_rules.h"
#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::coupling_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;

std::unique_ptr<Session> two_balls(const PeerOptions& options, const LinkOptions& link = {},
                                   double hz = 60.0) {
  auto session = std::make_unique<Session>(link);
  for (PeerId id = 1; id <= 2; ++id) {
    session->add(id, 0.0, options, kWeightless, hz).share(ball(Vec3::Zero()));
  }
  return session;
}

PeerOptions published(double share, bool thresholds) {
  PeerOptions options{.coupling = Coupling::TwoStep, .two_step_thresholds = thresholds};
  options.influence.baseline = share;
  return with_published_rules(options);
}

TEST_CASE("coupling: as published, each step leaves 1 - 2 s of a difference, by Eq. 1",
          "[consensus][analytic]") {
  const double share = GENERATE(0.25, 0.08);
  const bool thresholds = GENERATE(true, false);
  const auto session = two_balls(published(share, thresholds));
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  const Vec3 velocity(0.5, 0.0, 0.0);
  const Vec3 apart(0.0, 0.1, 0.0);
  for (Site* site : {&a, &b}) site->world.set_twist(site->body, {velocity, Vec3::Zero()});
  b.displace(apart);
  session->run(2.0 * kFrame);
  // Neither gain rule nor age nor initiative, and no delay: x_a + s (x_b - x_a) at either side.
  // Steps are whole nanoseconds, and shares travel as 32 bits.
  double left = b.x().y() - a.x().y();
  for (int i = 0; i < 4; ++i) {
    session->run(kFrame);
    CHECK(b.x().y() - a.x().y() == Approx((1.0 - 2.0 * share) * left).epsilon(1e-7));
    left = b.x().y() - a.x().y();
    CHECK(b.x().y() + a.x().y() == Approx(apart.y()).epsilon(1e-9));
    CHECK(a.v() == velocity);
  }
}

TEST_CASE("coupling: thresholds leave each difference below its limit, without them all vanish",
          "[consensus]") {
  for (const bool thresholds : {true, false}) {
    const auto session = two_balls(published(0.2, thresholds));
    Site& a = (*session)[0];
    Site& b = (*session)[1];
    b.displace({0.9e-3, 0.0, 0.0});
    // Well above its limit, so that what is below in one matters not for the other.
    b.world.set_twist(b.body, {Vec3::Zero(), Vec3(0.0, 0.0, 0.1)});
    session->run(1.0);
    CHECK((gap(a, b) == Approx(0.9e-3)) == thresholds);
    CHECK((gap(a, b) < 1e-8) == !thresholds);
    const double spin = b.twist().angular.z() - a.twist().angular.z();
    CHECK(spin < 1e-2);
    CHECK((spin > 1e-3) == thresholds);
  }
}

TEST_CASE("coupling: two steps leave a sleeping body asleep where one pass does", "[consensus]") {
  const auto session = std::make_unique<Session>();
  for (PeerId id = 1; id <= 2; ++id) {
    Site& site = session->add(id, 0.0, published(0.1, false));
    site.share(cube({0.0, 0.0, kHalf.z()}));
    put_on_plane(site);
  }
  session->run(4.0);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  CHECK_FALSE(a.world.awake(a.body));
  // Bodies that move there also move here.
  b.displace({0.05, 0.0, 0.0});
  session->run(0.1);
  CHECK(a.world.awake(a.body));
  CHECK(gap(a, b) < 0.04);
}

TEST_CASE("coupling: none leaves a world as it is without peers, bit for bit", "[consensus]") {
  Session session(network_profile(3));
  std::vector<std::unique_ptr<pbd::World>> alone;
  std::vector<std::unique_ptr<tandem::testing::ToyContacts>> contacts;
  pbd::Solver solver;
  for (PeerId id = 1; id <= 2; ++id) {
    Site& site = session.add(id, 0.0, {.coupling = Coupling::None});
    pbd::BodyDef def = cube({0.0, 0.0, 0.3 * static_cast<double>(id)});
    def.twist.angular = Vec3(3.0, 1.0, 0.0);
    site.share(def);
    put_on_plane(site);
    // The same without a peer.
    alone.push_back(std::make_unique<pbd::World>());
    contacts.push_back(std::make_unique<tandem::testing::ToyContacts>());
    const pbd::BodyId body = alone.back()->add_body(def);
    const pbd::BodyId ground = alone.back()->add_body({.type = pbd::BodyType::Static});
    contacts.back()->box_on_plane(ground, Vec3::UnitZ(), 0.0, body, kHalf, {.friction = 0.5});
    alone.back()->set_contact_source(contacts.back().get());
  }
  int compared = 0;
  session.after = [&](Site& site) {
    pbd::World& world = *alone[site.id - 1];
    const SessionTime from = site.step_time(site.steps - 1);
    solver.step(world, 1e-9 * static_cast<double>(site.step_time(site.steps) - from));
    CHECK(world.hash() == site.world.hash());
    ++compared;
  };
  session.run(2.0);
  CHECK(compared == 240);
  CHECK(session[0].peer->stats().bytes_sent > 0);
  CHECK(session[0].peer->stats().updates_received > 0);
  CHECK(session[0].peer->stats().bodies_aggregated == 0);
}

TEST_CASE("coupling: without coupling, copies still follow a body driven by hand", "[consensus]") {
  Session session;
  for (PeerId id = 1; id <= 2; ++id) {
    session.add(id, 0.0, {.coupling = Coupling::None}, kWeightless).share(ball(Vec3::Zero()), 2);
  }
  session.run(0.2);
  session[1].displace({0.5, 0.0, 0.0});
  session.run(0.2);
  CHECK(gap(session[0], session[1]) < 1e-6);
}

TEST_CASE("coupling: nobody leads where initiative is off", "[consensus]") {
  for (const bool initiative : {true, false}) {
    StubTransport transport(1);
    transport.known.push_back({.id = 2, .connected = true});
    Site site(transport, {.initiative = initiative, .authority_ramp = 0.0}, kWeightless);
    site.share(ball(Vec3::Zero()));
    site.peer->grab({.body = kBody});
    for (int i = 0; i < 10; ++i) {
      const SessionTime now = kStart + i * ns(kFrame);
      site.peer->before_step(now);
      site.solver.step(site.world, kFrame);
      site.peer->after_step(now + ns(kFrame));
    }
    DecodedPacket last;
    REQUIRE(decode(transport.posted.back(), last).ok());
    REQUIRE(last.states.size() == 1);
    CHECK(last.states[0].flags.held);
    CHECK(last.states[0].flags.leads == initiative);
    CHECK((last.states[0].influence > 0.2F) == initiative);
  }
}

TEST_CASE("coupling: copies on different faces are averaged where arbitration is off",
          "[consensus]") {
  // Free and 1.4 rad apart, which is beyond doubt down to 1.2 rad: so far the lower id stays.
  for (const bool arbitration : {true, false}) {
    Session session;
    for (PeerId id = 1; id <= 2; ++id) {
      const double angle = id == 2 ? 1.4 : 0.0;
      session.add(id, 0.0, {.arbitration = arbitration, .authority_ramp = 0.0}, kWeightless)
          .share(cube(Vec3::Zero(), Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()))));
    }
    session.run(4.0);
    const double first = session[0].pose().orientation.angularDistance(Quat::Identity());
    const double apart =
        session[0].pose().orientation.angularDistance(session[1].pose().orientation);
    CHECK(apart < 0.01);
    if (arbitration) CHECK(first < 0.6);
    if (!arbitration) CHECK(first == Approx(0.7).margin(0.05));
  }
}

}  // namespace
}  // namespace tandem::consensus::coupling_test
