// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A user's spring is simulated by every peer, and ends where the user's peer says or falls silent.
#include <cmath>

#include "consensus/peer_fixture.h"
#include "consensus/random.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::springs_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;
constexpr double kMass = 1.0;
constexpr double kG = 9.81;

/// Two peers with a ball each.
std::unique_ptr<Session> pair_of_peers(const LinkOptions& link, const PeerOptions& options,
                                       const pbd::WorldDef& def = kWeightless) {
  auto session = std::make_unique<Session>(link);
  for (int i = 0; i < 2; ++i) {
    session->add(static_cast<PeerId>(i + 1), 0.007 * i, options, def).share(ball(Vec3::Zero()));
  }
  return session;
}

TEST_CASE("springs: a hand at rest carries the body at every peer alike", "[consensus]") {
  const auto session = pair_of_peers(network_profile(4), springs_only(), {});
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  for (auto& site : session->sites) site->world.set_gravity(Vec3::Zero());
  session->run(0.2);
  a.peer->grab({.body = kBody,
                .attachment_l = Vec3(0.0, 0.0, 0.1),
                .anchor_w = Vec3(0.3, 0.0, 0.5),
                .stiffness = 200.0,
                .damping = 20.0});
  session->run(0.3);
  CHECK(a.peer->held(kBody));
  CHECK(b.peer->held(kBody));
  for (auto& site : session->sites) site->world.set_gravity(Vec3(0.0, 0.0, -kG));
  session->run(12.0);
  // The attachment hangs below the anchor by m g / k, the centre below the attachment.
  const Vec3 wanted(0.3, 0.0, 0.5 - kMass * kG / 200.0 - 0.1);
  CHECK((a.x() - wanted).norm() < 1e-3);
  CHECK((b.x() - wanted).norm() < 1e-3);
}

TEST_CASE("springs: the anchor's movement and the release travel", "[consensus]") {
  const auto session = pair_of_peers(network_profile(2), springs_only());
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  session->run(0.2);
  const GrabId grab =
      a.peer->grab({.body = kBody, .anchor_w = Vec3::Zero(), .stiffness = 500.0, .damping = 50.0});
  // 0.4 m/s along y for one second.
  SessionTime begin = 0;
  a.user = [&](Site& site, SessionTime now) {
    if (begin == 0) begin = now;
    site.peer->move(grab, Vec3(0.0, std::min(0.4e-9 * static_cast<double>(now - begin), 0.4), 0.0),
                    now);
  };
  session->run(0.8);
  // Both follow the same hand, carried on to now: no lag between them but their step phases.
  CHECK(gap_now(a, b) < 1e-3);
  CHECK(b.v().y() == Approx(0.4).epsilon(0.02));
  session->run(2.0);
  CHECK((b.x() - Vec3(0.0, 0.4, 0.0)).norm() < 1e-3);
  a.user = nullptr;
  a.peer->release(grab);
  CHECK_FALSE(a.peer->held(kBody));
  session->run(0.1);
  CHECK_FALSE(b.peer->held(kBody));
  CHECK(b.tethers().size() == 0);
}

TEST_CASE("springs: a hand that came to rest keeps its hold", "[consensus]") {
  // Nothing new is said about it for longer than the timeout.
  const auto session = pair_of_peers(network_profile(2), springs_only());
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  session->run(0.2);
  const GrabId grab = a.peer->grab({.body = kBody, .stiffness = 500.0, .damping = 50.0});
  SessionTime begin = 0;
  a.user = [&](Site& site, SessionTime now) {
    if (begin == 0) begin = now;
    const double t = 1e-9 * static_cast<double>(now - begin);
    if (t <= 0.5) site.peer->move(grab, Vec3(t, 0.0, 0.0), now);
  };
  session->run(4.0);
  CHECK(b.peer->held(kBody));
  CHECK((a.x() - Vec3(0.5, 0.0, 0.0)).norm() < 0.01);
  CHECK((b.x() - a.x()).norm() < 1e-3);
}

TEST_CASE("springs: an anchor is extrapolated by its velocity, but only for a time",
          "[consensus]") {
  PeerOptions options = springs_only();
  options.max_anchor_extrapolation = 0.3;
  options.spring_timeout = 10.0;
  const auto session = pair_of_peers(network_profile(1), options);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  session->run(0.2);
  const GrabId grab = a.peer->grab({.body = kBody, .stiffness = 2000.0, .damping = 90.0});
  SessionTime begin = 0;
  a.user = [&](Site& site, SessionTime now) {
    if (begin == 0) begin = now;
    site.peer->move(grab, Vec3(0.5e-9 * static_cast<double>(now - begin), 0.0, 0.0), now);
  };
  session->run(1.0);
  session->network.cut(1, 2);
  const double there = b.x().x();
  session->run(0.2);
  // It goes on at the hand's speed without a word from the other,
  CHECK(b.x().x() - there == Approx(0.2 * 0.5).epsilon(0.03));
  CHECK(gap_now(a, b) < 2e-3);
  session->run(3.0);
  // 0.3 s after the last stamp it stands, up to a step and the latency before the cut.
  CHECK(b.x().x() > there + 0.5 * (0.3 - 2.5 * kFrame));
  CHECK(b.x().x() < there + 0.5 * (0.3 + kFrame));
  CHECK(b.v().norm() < 1e-3);
  CHECK(b.peer->held(kBody));
}

TEST_CASE("springs: a body that is shared while somebody holds it is held at once", "[consensus]") {
  // Compact, springs are told in full every two seconds alone, and their anchors in each update.
  PeerOptions options = springs_only();
  options.sending.format = StateFormat::Compact;
  auto session = std::make_unique<Session>(network_profile(2));
  for (int i = 0; i < 2; ++i) {
    session->add(static_cast<PeerId>(i + 1), 0.007 * i, options, kWeightless);
  }
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  a.share(ball(Vec3::Zero()));
  session->run(0.2);
  const GrabId grab = a.peer->grab({.body = kBody});
  session->run(0.3);
  CHECK(b.tethers().size() == 0);
  b.share(ball(Vec3::Zero()));
  session->run(0.25);
  CHECK(b.tethers().size() == 1);
  CHECK(b.peer->held(kBody));
  a.peer->release(grab);
  session->run(0.5);
  CHECK(b.tethers().size() == 0);
  // A spring released before the body was shared does not pull.
  b.peer->unshare(kBody);
  const GrabId other = a.peer->grab({.body = kBody});
  session->run(0.2);
  a.peer->release(other);
  session->run(0.3);
  b.peer->share({.id = kBody, .body = b.body});
  session->run(2.5);
  CHECK(b.tethers().size() == 0);
}

TEST_CASE("springs: lost, doubled and overtaken messages leave no orphan", "[consensus][fault]") {
  // Nothing may be left to the timeout.
  PeerOptions options = springs_only();
  options.spring_timeout = 1000.0;
  LinkOptions link = network_profile(3);
  link.jitter = 0.02;
  link.loss = 0.3;
  link.duplicate = 0.3;
  link.reorder = 0.3;
  link.reorder_delay = 0.15;
  const auto session = pair_of_peers(link, options);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  Dice dice(11);
  int seen = 0;
  for (int i = 0; i < 40; ++i) {
    const GrabId grab = a.peer->grab({.body = kBody});
    // From one frame, announced in one packet or not at all, to half a second.
    session->run(kFrame * static_cast<double>(dice.below(30)));
    seen += b.tethers().size();
    a.peer->release(grab);
    session->run(kFrame * static_cast<double>(dice.below(20)));
  }
  CHECK(seen > 10);
  // Ten resends of twice the latency and the longest hold-up.
  session->run(1.0);
  CHECK(b.tethers().size() == 0);
  CHECK_FALSE(b.peer->held(kBody));
  CHECK(b.peer->stats().springs_refused == 0);
}

TEST_CASE("springs: those of a silent peer are let go, and held again when it is back",
          "[consensus][fault]") {
  const auto session = pair_of_peers(network_profile(2), springs_only());
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  session->run(0.2);
  a.peer->grab({.body = kBody});
  session->run(0.3);
  session->network.cut(1, 2);
  session->run(0.9);
  CHECK(b.peer->held(kBody));
  session->run(0.2);
  CHECK_FALSE(b.peer->held(kBody));
  CHECK(b.tethers().size() == 0);
  CHECK(a.peer->held(kBody));
  session->network.heal(1, 2);
  session->run(0.1);
  CHECK(b.peer->held(kBody));
  CHECK(b.tethers().size() == 1);
}

TEST_CASE("springs: a farewell lets go at once, and late packets do not undo it", "[consensus]") {
  PeerOptions options = springs_only();
  options.spring_timeout = 1000.0;
  LinkOptions link = network_profile(2);
  link.reorder = 0.5;
  link.reorder_delay = 0.1;
  const auto session = pair_of_peers(link, options);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  session->run(0.2);
  a.peer->grab({.body = kBody});
  a.peer->grab({.body = kBody, .attachment_l = Vec3(0.0, 0.0, 0.1)});
  session->run(0.3);
  REQUIRE(b.tethers().size() == 2);
  a.peer->leave(a.step_time(a.steps));
  session->sites.erase(session->sites.begin());
  session->run(3.0 * kFrame);
  CHECK_FALSE(session->sites[0]->peer->held(kBody));
  session->run(0.5);
  CHECK(session->sites[0]->tethers().size() == 0);
}

TEST_CASE("springs: a restarted peer grabs again at once", "[consensus]") {
  // The other still remembers the springs of its predecessor, whether they have the same ids (both
  // grabbed before their first step) or not; those not released end with the timeout.
  const bool released = GENERATE(false, true);
  const bool early = GENERATE(false, true);
  CAPTURE(released, early);
  const auto session = pair_of_peers(network_profile(2), springs_only());
  Site& b = (*session)[1];
  const GrabDef first{.body = kBody, .anchor_w = Vec3(0.0, 0.0, 0.1)};
  GrabId grab;
  if (early) grab = (*session)[0].peer->grab(first);
  session->run(0.2);
  if (!early) grab = (*session)[0].peer->grab(first);
  session->run(0.3);
  REQUIRE(b.peer->held(kBody));
  if (released) (*session)[0].peer->release(grab);
  session->run(0.1);
  REQUIRE(b.peer->held(kBody) == !released);

  session->sites.erase(session->sites.begin());
  session->run(0.2);
  Site& again = session->add(1, 0.002, springs_only(), kWeightless);
  again.share(ball(Vec3::Zero()));
  const GrabDef second{
      .body = kBody, .anchor_w = Vec3(0.5, 0.0, 0.0), .stiffness = 500.0, .damping = 50.0};
  if (early) again.peer->grab(second);
  session->run(0.03);
  if (!early) again.peer->grab(second);
  session->run(0.07);
  CHECK(b.tethers().size() == (released || early ? 1 : 2));
  session->run(3.0);
  CHECK(b.tethers().size() == 1);
  CHECK((b.x() - second.anchor_w).norm() < 1e-3);
}

TEST_CASE("springs: messages that come late change nothing", "[consensus][fault]") {
  StubTransport transport(1);
  Site site(transport, springs_only(), kWeightless);
  site.share(ball(Vec3::Zero()));
  const auto deliver = [&](SpringEvent event, std::uint32_t revision, double stamp, double anchor) {
    transport.deliver(2, SpringUpdate{.spring = 7,
                                      .revision = revision,
                                      .event = event,
                                      .body = kBody,
                                      .anchor_w = Vec3(anchor, 0.0, 0.0),
                                      .stiffness = 100.0,
                                      .damping = 1.0,
                                      .max_force = 10.0,
                                      .stamp = kStart + ns(stamp)});
    site.peer->before_step(kStart + ns(0.1));
  };
  const auto anchor = [&] { return site.tethers().def({0, 0}).anchor_w.x(); };
  deliver(SpringEvent::Create, 1, 0.00, 0.1);
  CHECK(anchor() == 0.1);
  deliver(SpringEvent::Change, 1, 0.04, 0.4);
  const double carried = anchor();
  CHECK(carried > 0.4);
  deliver(SpringEvent::Change, 1, 0.03, 0.3);
  deliver(SpringEvent::Create, 1, 0.00, 0.1);
  CHECK(anchor() == carried);
  SECTION("after the removal") {
    deliver(SpringEvent::Remove, 2, 0.05, 0.5);
    CHECK(site.tethers().size() == 0);
    deliver(SpringEvent::Change, 1, 0.06, 0.6);
  }
  SECTION("after the farewell, by a clock that is ahead of ours") {
    transport.deliver(2, Leave{.stamp = kStart + ns(0.12)});
    site.peer->before_step(kStart + ns(0.1));
    CHECK(site.tethers().size() == 0);
    deliver(SpringEvent::Change, 1, 0.11, 0.6);
  }
  CHECK(site.tethers().size() == 0);
}

TEST_CASE("springs: a peer holds 64 at most, the others are counted", "[consensus][fault]") {
  StubTransport transport(1);
  PeerOptions options;
  options.robust.max_springs_per_body = 1000;
  Site site(transport, options, kWeightless);
  site.share(ball(Vec3::Zero()));
  for (std::uint32_t i = 1; i <= 100; ++i) {
    transport.deliver(2, SpringUpdate{.spring = i,
                                      .revision = 1,
                                      .event = SpringEvent::Create,
                                      .body = kBody,
                                      .stiffness = 1.0,
                                      .damping = 0.1,
                                      .max_force = 1.0,
                                      .stamp = kStart});
  }
  site.peer->before_step(kStart);
  CHECK(site.tethers().size() == 64);
  CHECK(site.peer->stats().springs_refused == 36);
  // Another peer has its own.
  transport.deliver(3, SpringUpdate{.spring = 1,
                                    .revision = 1,
                                    .body = kBody,
                                    .stiffness = 1.0,
                                    .max_force = 1.0,
                                    .stamp = kStart});
  site.peer->before_step(kStart + ns(kFrame));
  CHECK(site.tethers().size() == 65);
}

TEST_CASE("springs: a hand that has let go may hold again at once", "[consensus][fault]") {
  StubTransport transport(1);
  Site site(transport, PeerOptions{}, kWeightless);
  site.share(ball(Vec3::Zero()));
  SessionTime now = kStart;
  // Somebody who taps, faster than what is let go is forgotten.
  for (std::uint32_t i = 1; i <= 300; ++i, now += ns(kFrame)) {
    SpringUpdate spring{.spring = i,
                        .revision = 1,
                        .event = SpringEvent::Create,
                        .body = kBody,
                        .stiffness = 1.0,
                        .damping = 0.1,
                        .max_force = 1.0,
                        .stamp = now};
    transport.deliver(2, spring);
    site.peer->before_step(now);
    CHECK(site.tethers().size() == 1);
    spring.revision = 2;
    spring.event = SpringEvent::Remove;
    spring.stamp = now + 1;
    transport.deliver(2, spring);
  }
  CHECK(site.peer->stats().springs_refused == 0);
}

TEST_CASE("springs: one too soft to compute with is refused and counted", "[consensus][fault]") {
  StubTransport transport(1);
  Site site(transport, {}, kWeightless);
  site.share(ball(Vec3::Zero()));
  for (const double stiffness : {1e-310, 1e-150, 1e-12}) {
    transport.deliver(2, SpringUpdate{.spring = 1,
                                      .revision = 1,
                                      .event = SpringEvent::Create,
                                      .body = kBody,
                                      .stiffness = stiffness,
                                      .max_force = 1.0,
                                      .stamp = kStart});
  }
  site.peer->before_step(kStart);
  CHECK(site.tethers().size() == 0);
  CHECK(site.peer->stats().springs_refused >= 1);
}

TEST_CASE("springs: their numbers may wrap around", "[consensus]") {
  StubTransport transport(1);
  Site site(transport, {}, kWeightless);
  site.share(ball(Vec3::Zero()));
  // Numbers go on from the session's time in milliseconds.
  const SessionTime last = SessionTime{0xffffffff} * 1'000'000;
  site.peer->before_step(last);
  std::vector<GrabId> grabs;
  for (int i = 0; i < 4; ++i) grabs.push_back(site.peer->grab({.body = kBody}));
  CHECK(grabs[0].spring == 0xffffffff);
  CHECK(grabs[1].spring == 1);
  for (const GrabId grab : grabs) {
    CHECK_NOTHROW(site.peer->move(grab, Vec3::Zero(), last + ns(kFrame)));
  }
  for (const GrabId grab : grabs) CHECK_NOTHROW(site.peer->release(grab));
  CHECK(site.tethers().size() == 0);
}

TEST_CASE("springs: one's own are named by grab() until they are released", "[consensus]") {
  StubTransport transport(1);
  Site site(transport, {}, kWeightless);
  site.share(ball(Vec3::Zero()));
  const GrabId grab = site.peer->grab({.body = kBody});
  CHECK_NOTHROW(site.peer->move(grab, Vec3::Zero(), kStart));
  CHECK_THROWS_AS(site.peer->move({grab.spring + 1}, Vec3::Zero(), kStart), std::invalid_argument);
  CHECK_THROWS_AS(site.peer->move(grab, Vec3(NAN, 0.0, 0.0), kStart), std::invalid_argument);
  CHECK_THROWS_AS(site.peer->grab({.body = SharedId::from_name("other")}), std::invalid_argument);
  CHECK_THROWS_AS(site.peer->grab({.body = kBody, .stiffness = -1.0}), std::invalid_argument);
  site.peer->release(grab);
  CHECK_THROWS_AS(site.peer->release(grab), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::consensus::springs_test
