// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who acts on a body, and alone, leads: no throw and no stroke is held back by peers that do not
// know of it yet.
#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "consensus/peer_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::initiative_test {
namespace {

using namespace testing;

constexpr double kGrabs = 1.2, kLetsGo = 1.6;  // s; everybody is established by then
constexpr double kAcceleration = 10.0;         // m/s^2, of the hand

double since_start(SessionTime time) { return 1e-9 * static_cast<double>(time - kStart); }

/// Says whether the newest state that was heard claims to lead.
class Claims final : public PeerObserver {
 public:
  void on_estimate(const EstimateEvent& event) override {
    leads = event.update.flags.leads;
    led[event.update.id] = leads;
  }
  bool leads = false;
  std::map<SharedId, bool> led;  ///< by body
};

/// A user who grabs the body where it is, pulls it along x and lets go; only once.
std::function<void(Site&, SessionTime)> thrower(double from, double to) {
  return
      [from, to, grip = GrabId{}, start = Vec3(Vec3::Zero())](Site& site, SessionTime now) mutable {
        const double t = since_start(now);
        if (t >= to) {
          if (grip.spring != 0) site.peer->release(grip);
          grip = {};
          return;
        }
        if (t < from) return;
        if (grip.spring == 0) {
          start = site.x();
          grip = site.peer->grab({.body = kBody, .anchor_w = start});
        }
        site.peer->move(grip, start + Vec3(0.5 * kAcceleration * (t - from) * (t - from), 0.0, 0.0),
                        now);
      };
}

/// Two peers with a ball in weightless space; the first throws it.
std::unique_ptr<Session> throw_ball(int profile, int peers) {
  auto session = std::make_unique<Session>(network_profile(profile));
  for (int i = 0; i < peers; ++i) {
    session->add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless).share(ball(Vec3::Zero()));
  }
  (*session)[0].user = thrower(kGrabs, kLetsGo);
  return session;
}

TEST_CASE("initiative: peers that have not heard of a throw do not hold it back", "[consensus]") {
  std::vector<Vec3> velocities[2];
  for (const int peers : {1, 2}) {
    const auto session = throw_ball(5, peers);
    session->after = [&](Site& site) {
      if (site.id == 1) velocities[peers - 1].push_back(site.v());
    };
    session->run(3.0);
    if (peers == 1) continue;
    const Site& follower = (*session)[1];
    INFO(follower.x().transpose() << ", thrower " << (*session)[0].x().transpose());
    CHECK(follower.v().x() > 3.0);  // a push of 10 m/s^2 for 0.4 s
    // It missed about a A^2 / 2 = 0.1 m at first; a quarter of what is left goes with each step.
    CHECK(gap_now((*session)[0], follower) < 1e-3);
  }
  REQUIRE(velocities[0].size() == velocities[1].size());
  for (std::size_t i = 0; i < velocities[0].size(); ++i) {
    CHECK((velocities[1][i] - velocities[0][i]).norm() < 1e-9);
  }
}

TEST_CASE("initiative: a stroke with an own body is a user's act as well", "[consensus]") {
  // A heavy kinematic ball of peer 1 runs into the shared one: alone, that leaves twice as fast.
  constexpr double kSpeed = 2.0;
  Session session(network_profile(5));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless);
    site.share(ball(Vec3::Zero()));
    pbd::BodyDef racket = ball(Vec3(-3.0, 0.0, 0.0), Vec3(i == 0 ? kSpeed : 0.0, 0.0, 0.0));
    if (i == 0) racket.type = pbd::BodyType::Kinematic;
    const pbd::BodyId body = site.world.add_body(racket);
    site.peer->share({.id = SharedId::from_name("racket"), .body = body, .owner = 1});
    site.contacts.ball_on_ball(body, kBallRadius, site.body, kBallRadius,
                               {.friction = 0.0, .restitution = 1.0});
    site.world.set_contact_source(&site.contacts);
  }
  std::optional<double> slowest;
  session.after = [&](Site& site) {
    // It touches at 1.4 s.
    if (site.id != 1 || since_start(site.world_time()) < 1.45) return;
    slowest = std::min(slowest.value_or(1e9), site.v().x());
  };
  session.run(2.5);
  REQUIRE(slowest.has_value());
  CHECK(*slowest == Approx(2.0 * kSpeed).epsilon(1e-3));
  CHECK(gap_now(session[0], session[1]) < 5e-3);
}

TEST_CASE("initiative: nobody leads a body that two hold", "[consensus]") {
  Session session(network_profile(3));
  Claims claims[2];
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless);
    site.share(ball(Vec3::Zero()));
    site.peer->set_observer(&claims[i]);
  }
  session.run(1.2);
  const auto hold = [](Site& site) {
    site.user = [grip = GrabId{}](Site& s, SessionTime now) mutable {
      if (grip.spring == 0) grip = s.peer->grab({.body = kBody, .anchor_w = Vec3::Zero()});
      s.peer->move(grip, Vec3::Zero(), now);
    };
  };
  CHECK_FALSE(claims[1].leads);
  hold(session[0]);
  session.run(0.2);
  CHECK(claims[1].leads);
  hold(session[1]);
  session.run(0.2);
  CHECK_FALSE(claims[0].leads);
  CHECK_FALSE(claims[1].leads);
}

TEST_CASE("initiative: no peer leads a bar that two users hold at its ends", "[consensus]") {
  // Each would follow the other's end and hold on to its own: a loop, and no follower of one that
  // does not listen.
  const SharedId far_end = SharedId::from_name("far end");
  Session session(network_profile(3));
  Claims claims[2];
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless);
    site.share(ball(Vec3::Zero()));
    const pbd::BodyId middle = site.world.add_body(ball(Vec3(0.5, 0.0, 0.0)));
    const pbd::BodyId end = site.world.add_body(ball(Vec3(1.0, 0.0, 0.0)));
    auto& joints = site.world.add_block<pbd::JointBlock>();
    joints.add(site.world, pbd::fixed_joint_at(site.world, middle, end, Vec3(0.7, 0.0, 0.0)));
    joints.add(site.world, pbd::fixed_joint_at(site.world, site.body, middle, Vec3(0.2, 0.0, 0.0)));
    site.peer->share({.id = far_end, .body = end});
    site.peer->set_observer(&claims[i]);
  }
  session.run(1.2);
  const auto hold = [](Site& site, const SharedId& what, const Vec3& where) {
    site.user = [=, grip = GrabId{}](Site& s, SessionTime now) mutable {
      if (grip.spring == 0) grip = s.peer->grab({.body = what, .anchor_w = where});
      s.peer->move(grip, where, now);
    };
  };
  hold(session[0], kBody, Vec3::Zero());
  session.run(0.2);
  CHECK(claims[1].led[kBody]);
  CHECK_FALSE(claims[1].led[far_end]);
  hold(session[1], far_end, Vec3(1.0, 0.0, 0.0));
  session.run(0.2);
  for (const Claims& claim : claims) {
    for (const auto& [id, leads] : claim.led) CHECK_FALSE(leads);
  }
}

TEST_CASE("initiative: it ends where the body comes to rest, and everybody is heard again",
          "[consensus]") {
  Session session(network_profile(5));
  Claims claims;
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i);
    site.share(cube(Vec3(0.0, 0.0, kHalf.z())));
    put_on_plane(site);
  }
  session[1].peer->set_observer(&claims);
  session[0].user = thrower(kGrabs, kLetsGo);
  session.run(1.6);
  CHECK(claims.leads);
  session.run(1.5);
  CHECK_FALSE(claims.leads);
  // The follower's view counts: had it to do all the way alone, peer 1 would stay where it is.
  const Vec3 before = session[0].x();
  session[1].displace({0.05, 0.0, 0.0});
  session.run(1.0);
  CHECK(session[0].x().x() > before.x() + 0.01);
}

TEST_CASE("initiative: a dropped body lands alike, and all peers are heard again", "[consensus]") {
  // It falls for longer than the news of it needs to go there and back.
  Session session(network_profile(5));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i);
    site.share(cube(Vec3(0.0, 0.0, 6.0)));
    put_on_plane(site);
  }
  double landed = 0.0;
  session.after = [&](Site& site) {
    const double now = since_start(site.world_time());
    if (landed == 0.0 && now > kLetsGo && site.world.in_contact(site.body)) landed = now;
  };
  session[0].user = [grip = GrabId{}](Site& site, SessionTime now) mutable {
    if (grip.spring == 0) grip = site.peer->grab({.body = kBody, .anchor_w = site.x()});
    if (since_start(now) > kLetsGo && site.peer->held(kBody)) site.peer->release(grip);
  };
  session.run(3.6);
  REQUIRE(landed > 0.0);
  REQUIRE(landed < 2.8);
  CHECK((session[0].x() - session[1].x()).norm() < 1e-3);
  // A body at rest at the same place everywhere is not looked at until it is moved.
  const double before = session[0].x().x();
  session[1].displace({0.05, 0.0, 0.0});
  session.run(1.0);
  CHECK(session[0].x().x() > before + 0.01);
}

TEST_CASE("initiative: the later act has it", "[consensus]") {
  const auto session = throw_ball(4, 2);
  session->run(2.5);
  const Vec3 first = (*session)[0].v();
  (*session)[1].user = thrower(2.6, 2.9);
  session->run(0.8);
  // Peer 1's throw was still in flight. Both fly as peer 2 threw, from where it held.
  CHECK((*session)[1].v().x() > 2.5);
  CHECK(((*session)[0].v() - (*session)[1].v()).norm() < 0.05);
  CHECK(((*session)[0].v() - first).norm() > 0.5);
  CHECK(gap_now((*session)[0], (*session)[1]) < 0.02);
}

}  // namespace
}  // namespace tandem::consensus::initiative_test
