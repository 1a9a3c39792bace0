// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What cannot come together by averaging, and what is put somewhere else on purpose.
#include <numbers>

#include "consensus/peer_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus::jump_test {
namespace {

using namespace testing;

/// Counts the states that tell of a jump.
class Jumps final : public PeerObserver {
 public:
  void on_estimate(const EstimateEvent& event) override {
    if (!event.update.flags.teleported || event.update.stamp <= last_) return;
    last_ = event.update.stamp;
    ++told;
  }
  int told = 0;

 private:
  SessionTime last_ = 0;
};

/// A ball at `x` and, fixed at the origin, a ball of 0.2 m.
void share_beside_post(Site& site, double x, std::optional<PeerId> owner = std::nullopt) {
  constexpr double kPost = 0.2;
  site.share(ball(Vec3(x, 0.0, 0.0)), owner);
  pbd::BodyDef post;
  post.type = pbd::BodyType::Static;
  site.contacts.ball_on_ball(site.world.add_body(post), kPost, site.body, kBallRadius,
                             {.friction = 0.0});
  site.world.set_contact_source(&site.contacts);
}

TEST_CASE("jump: copies on different sides of something solid come together", "[consensus]") {
  // On one line with the post, so that neither slides around it.
  for (const int profile : {1, 3, 5}) {
    Session session(network_profile(profile));
    for (int i = 0; i < 2; ++i) {
      // No ramp: newcomers would take over at once, see below.
      Site& site =
          session.add(static_cast<PeerId>(i + 1), 0.007 * i, {.authority_ramp = 0.0}, kWeightless);
      share_beside_post(site, i == 0 ? 0.3 : -0.3);
    }
    session.run(1.0);
    CHECK(gap(session[0], session[1]) > 0.55);
    session.run(3.0);
    INFO("profile " << profile << ": " << session[0].x().transpose() << ", "
                    << session[1].x().transpose());
    CHECK(gap(session[0], session[1]) < 1e-3);
    // The follower jumped, once, and says so.
    CHECK(session[0].x().x() > 0.29);
    CHECK(session[0].peer->stats().bodies_placed == 0);
    CHECK(session[1].peer->stats().bodies_placed == 1);
  }
}

TEST_CASE("jump: a newcomer's copy is not caught behind something solid", "[consensus]") {
  for (const int profile : {1, 5}) {
    Session session(network_profile(profile));
    share_beside_post(session.add(2, 0.0, {}, kWeightless), 0.3);
    session.run(2.0);
    // With the lower id: it follows for being new.
    Site& late = session.add(1, 0.007, {}, kWeightless);
    share_beside_post(late, -0.3);
    session.run(0.3);
    INFO("profile " << profile << ": " << session[0].x().transpose() << ", "
                    << session[1].x().transpose());
    CHECK(gap(session[0], session[1]) < 1e-3);
    CHECK(session[0].x().x() == Approx(0.3).margin(1e-3));
  }
}

TEST_CASE("jump: copies that come together by themselves are not placed", "[consensus]") {
  Session session(network_profile(5));
  for (int i = 0; i < 2; ++i) {
    session.add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless)
        .share(ball(Vec3(0.5 * i, 0.0, 0.0)));
  }
  session.run(6.0);
  CHECK(gap(session[0], session[1]) < 1e-3);
  for (const auto& site : session.sites) CHECK(site->peer->stats().bodies_placed == 0);
}

TEST_CASE("jump: a cube that lies on its other side comes to lie as the leader's does",
          "[consensus]") {
  Session session(network_profile(3));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i, {.authority_ramp = 0.0});
    const Quat turned = pbd::exp_map(Vec3(std::numbers::pi * i, 0.0, 0.0));
    site.share(cube({0.0, 0.0, kHalf.z()}, turned));
    put_on_plane(site);
  }
  const auto angle = [&] {
    return session[0].pose().orientation.angularDistance(session[1].pose().orientation);
  };
  CHECK(angle() > 3.0);
  const Quat lead = session[0].pose().orientation;
  session.run(5.0);
  CHECK(angle() < 1e-3);
  CHECK(session[0].pose().orientation.angularDistance(lead) < 1e-3);
  // No average turns it: it is drawn over, or put there.
  CHECK(session[0].peer->stats().bodies_placed == 0);
  CHECK(session[1].peer->stats().bodies_placed <= 1);
}

TEST_CASE("jump: where the ground is another one, a body is put there once at most",
          "[consensus]") {
  constexpr double kLower = 0.1;
  for (const bool follower_is_lower : {true, false}) {
    Session session(network_profile(3));
    for (int i = 0; i < 2; ++i) {
      Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i, {.authority_ramp = 0.0});
      const double ground = (i == 1) == follower_is_lower ? -kLower : 0.0;
      site.share(cube({0.0, 0.0, ground + kHalf.z()}));
      const pbd::BodyId plane = site.world.add_body({.type = pbd::BodyType::Static});
      site.contacts.box_on_plane(plane, Vec3::UnitZ(), ground, site.body, kHalf, {.friction = 0.5});
      site.world.set_contact_source(&site.contacts);
    }
    session.run(8.0);
    INFO((follower_is_lower ? "lower" : "higher"));
    CHECK(session[1].peer->stats().bodies_placed <= 1);
    // Both lie on their own ground; agreement lifts the lower one by its share in each step, and it
    // falls back.
    const double share = InfluenceOptions{}.baseline;
    CHECK(gap(session[0], session[1]) > (1.0 - 2.0 * share) * kLower);
    CHECK(gap(session[0], session[1]) < kLower + 1e-3);
  }
}

TEST_CASE("jump: a peer between two others that pull it apart is not put anywhere", "[consensus]") {
  // The middle one hears both and stays; the outer ones hear nobody: nothing ever changes, and no
  // peer is disturbed.
  Session session(network_profile(1));
  for (int i = 0; i < 3; ++i) {
    PeerOptions options{.authority_ramp = 0.0};
    if (i != 1) options.coupling = Coupling::None;
    session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless)
        .share(ball(Vec3(0.2 * i, 0.0, 0.0)));
  }
  session.run(5.0);
  CHECK(session[1].x().x() == Approx(0.2).margin(1e-3));
  CHECK(session[1].peer->stats().bodies_placed == 0);
}

TEST_CASE("jump: an owner's jump passes through bodies on its way and is no motion",
          "[consensus]") {
  constexpr PeerId kOwner = 1;
  Session session(network_profile(3));
  Jumps jumps;
  double fastest = 0.0;
  for (int i = 0; i < 2; ++i) {
    share_beside_post(session.add(static_cast<PeerId>(i + 1), 0.007 * i, {}, kWeightless), 1.0,
                      kOwner);
  }
  session[1].peer->set_observer(&jumps);
  session.run(1.5);
  CHECK(jumps.told == 0);
  session[0].world.set_pose(session[0].body, {Vec3(-1.0, 0.0, 0.0), Quat::Identity()});
  session.after = [&](Site& site) { fastest = std::max(fastest, site.v().norm()); };
  // The news takes 28.5 ms, and steps and updates one interval each.
  session.run(0.1);
  CHECK((session[1].x() - Vec3(-1.0, 0.0, 0.0)).norm() < 1e-9);
  session.run(1.0);
  CHECK(fastest < 1e-9);
  CHECK(jumps.told == 3);  // some of them might have got lost
}

}  // namespace
}  // namespace tandem::consensus::jump_test
