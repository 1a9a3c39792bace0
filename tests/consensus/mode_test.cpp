// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Soft, asymmetric and hard inputs, [friston] Secs. 3.5, 4.3 and 7.1.
#include <algorithm>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::mode_test {
namespace {

using namespace testing;

LinkOptions delayed(double seconds) {
  LinkOptions link;
  link.latency = seconds;
  return link;
}

std::unique_ptr<Session> pair_of(InputMode mode, const LinkOptions& link = {},
                                 const pbd::WorldDef& def = kWeightless) {
  auto session = std::make_unique<Session>(link);
  for (int i = 0; i < 2; ++i) {
    Site& site = session->add(static_cast<PeerId>(i + 1), 0.005 * i,
                              {.mode = mode, .authority_ramp = 0.0}, def);
    site.share(cube(Vec3::Zero()));
  }
  return session;
}

/// Grasps the cube and moves the hand from `from` by `velocity` for a second, then holds still.
std::function<void(Site&, SessionTime)> hand(const Vec3& attachment, const Vec3& velocity) {
  return [=, grab = GrabId{}](Site& site, SessionTime now) mutable {
    const double t = std::min(1e-9 * static_cast<double>(now - kStart), 1.0);
    if (grab.spring == 0) {
      grab = site.peer->grab({.body = kBody, .attachment_l = attachment, .anchor_w = attachment});
    }
    site.peer->move(grab, attachment + t * velocity, now);
  };
}

TEST_CASE("mode: a soft spring is simulated by all, others by their user's peer alone",
          "[consensus]") {
  for (const InputMode mode : {InputMode::Soft, InputMode::Asymmetric, InputMode::Hard}) {
    const auto session = pair_of(mode);
    (*session)[0].user = hand(Vec3::Zero(), Vec3(0.1, 0.0, 0.0));
    session->run(0.5);
    CHECK((*session)[0].tethers().size() == (mode == InputMode::Hard ? 0 : 1));
    CHECK((*session)[1].tethers().size() == (mode == InputMode::Soft ? 1 : 0));
    CHECK((*session)[0].peer->held(kBody));
    CHECK((*session)[1].peer->held(kBody) == (mode == InputMode::Soft));
  }
}

TEST_CASE("mode: in every mode both peers' bodies come to the hand", "[consensus]") {
  for (const InputMode mode : {InputMode::Soft, InputMode::Asymmetric, InputMode::Hard}) {
    const auto session = pair_of(mode, delayed(0.06));
    (*session)[0].user = hand(Vec3::Zero(), Vec3(0.3, 0.0, 0.0));
    session->run(4.0);
    for (int i = 0; i < 2; ++i) {
      INFO("mode " << static_cast<int>(mode) << ", peer " << i + 1);
      CHECK(((*session)[static_cast<std::size_t>(i)].x() - Vec3(0.3, 0.0, 0.0)).norm() < 5e-3);
    }
  }
}

TEST_CASE("mode: one spring may differ from the peer's mode", "[consensus]") {
  const auto session = pair_of(InputMode::Soft);
  Site& site = (*session)[0];
  site.peer->grab({.body = kBody, .mode = InputMode::Asymmetric});
  session->run(0.2);
  CHECK(site.tethers().size() == 1);
  CHECK((*session)[1].tethers().size() == 0);
}

TEST_CASE("mode: a hard input leaves physics no say", "[consensus][analytic]") {
  // Gravity pulls, the hand stands: the body does not sink, at either peer, nor does it swing.
  const auto session = pair_of(InputMode::Hard, delayed(0.06), {});
  (*session)[0].user = hand(Vec3::Zero(), Vec3::Zero());
  double moved[2] = {0.0, 0.0};
  session->after = [&](Site& site) {
    double& most = moved[site.id - 1];
    most = std::max({most, site.x().norm(), site.v().norm()});
  };
  session->run(2.0);
  CHECK(moved[0] == 0.0);
  // Until it heard of the hand the other's has fallen for 60 ms and a few steps.
  CHECK(moved[1] < 9.81 * 0.15);
  moved[1] = 0.0;
  session->run(1.0);
  CHECK(moved[1] < 1e-6);
  session->after = nullptr;
  // Let go, it falls.
  (*session)[0].user = nullptr;
  (*session)[0].peer->release({1});
  session->run(0.5);
  CHECK((*session)[0].v().z() < -2.0);
}

TEST_CASE("mode: of two hard hands both see the mean, each sends its own",
          "[consensus][analytic]") {
  // One hand at the centre goes to +0.2, the other to -0.2: the mean stays in the middle.
  for (const double delay : {0.0, 0.1235}) {
    const auto session = pair_of(InputMode::Hard, delayed(delay));
    (*session)[0].user = hand(Vec3::Zero(), Vec3(0.2, 0.0, 0.0));
    (*session)[1].user = hand(Vec3::Zero(), Vec3(-0.2, 0.0, 0.0));
    session->run(3.0);
    for (int i = 0; i < 2; ++i) {
      const Site& site = (*session)[static_cast<std::size_t>(i)];
      INFO("delay " << delay << " s, peer " << i + 1 << " at " << site.x().transpose());
      CHECK(site.x().norm() < 1e-3);
      CHECK(site.v().norm() < 1e-3);
    }
  }
}

TEST_CASE("mode: two hard hands turn a body that one cannot", "[consensus][analytic]") {
  // At the two ends of a body, moving against each other: it turns until it lies between them.
  const auto session = pair_of(InputMode::Hard, delayed(0.03));
  const Vec3 end(0.1, 0.0, 0.0);
  (*session)[0].user = hand(end, Vec3(-0.1, 0.1, 0.0));
  (*session)[1].user = hand(-end, Vec3(0.1, -0.1, 0.0));
  session->run(6.0);
  for (int i = 0; i < 2; ++i) {
    const Site& site = (*session)[static_cast<std::size_t>(i)];
    const Vec3 axis = site.pose().orientation * Vec3::UnitX();
    INFO("axis " << axis.transpose());
    CHECK((axis - Vec3::UnitY()).norm() < 0.05);
    CHECK(site.x().norm() < 5e-3);
  }
}

TEST_CASE("mode: a soft peer does not take a hard one for an owner", "[consensus][fault]") {
  Session session;
  Site& hard = session.add(1, 0.0, {.mode = InputMode::Hard, .authority_ramp = 0.0}, kWeightless);
  Site& soft = session.add(2, 0.005, {.authority_ramp = 0.0}, kWeightless);
  hard.share(cube(Vec3::Zero()));
  soft.share(cube(Vec3(0.1, 0.0, 0.0)));
  hard.user = hand(Vec3::Zero(), Vec3::Zero());
  session.run(0.1);
  // A follower would be there after one step; half of the gap in each is the most it is heard with.
  CHECK(soft.x().norm() > 1e-4);
  session.run(2.0);
  CHECK(soft.x().norm() < 1e-3);
}

TEST_CASE("mode: a clock that stands still or goes back moves nothing by hand",
          "[consensus][fault]") {
  StubTransport transport(1);
  Site site(transport, {.mode = InputMode::Hard, .authority_ramp = 0.0}, kWeightless);
  site.share(cube(Vec3::Zero()));
  const GrabId grab = site.peer->grab({.body = kBody});
  site.peer->before_step(kStart);
  site.peer->after_step(kStart + ns(0.016));
  site.peer->move(grab, Vec3(0.01, 0.0, 0.0), kStart + ns(0.016));
  for (const double at : {0.016, 0.016, -0.1, -0.1}) {
    CHECK_NOTHROW(site.peer->before_step(kStart + ns(at)));
    CHECK_NOTHROW(site.peer->after_step(kStart + ns(at)));
    CHECK(site.twist().linear.norm() < 5.0);
    CHECK(site.x().norm() < 0.05);
  }
}

TEST_CASE("mode: a peer that becomes the owner of a dragged body can still let go", "[consensus]") {
  const auto session = pair_of(InputMode::Hard);
  Site& site = (*session)[0];
  const GrabId grab = site.peer->grab({.body = kBody});
  site.user = [grab](Site& s, SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    if (t < 0.5) s.peer->move(grab, Vec3(0.2 * t, 0.0, 0.0), now);
  };
  session->run(0.25);
  site.peer->set_owner(kBody, site.id);
  session->run(0.1);
  CHECK(site.x().x() == Approx(0.2 * 0.35).margin(0.01));  // the hand goes on
  site.user = nullptr;
  site.peer->release(grab);
  session->run(0.1);
  // A released body follows physics again: a push counts.
  site.world.set_twist(site.body, {Vec3(0.0, 1.0, 0.0), Vec3::Zero()});
  session->run(0.1);
  CHECK(site.v().y() == Approx(1.0).margin(0.05));
}

}  // namespace
}  // namespace tandem::consensus::mode_test
