// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// No deadness: what peers disagree about goes away, and nothing grows.
#include <algorithm>
#include <array>
#include <cmath>

#include "consensus/peer_fixture.h"
#include "consensus/random.h"
#include "support/catch.h"
#include "support/oracles.h"

namespace tandem::consensus::peer_agreement_test {
namespace {

using tandem::testing::kPi;
using namespace testing;

/// All peers are past their authority ramps then.
constexpr double kSettled = 1.5;  // s
constexpr double kFrame = 1.0 / 60.0;

using Build = std::function<void(Site&)>;

void free_ball(Site& site) { site.share(ball(Vec3::Zero())); }
void resting_cube(Site& site) {
  site.share(cube({0.0, 0.0, kHalf.z()}));
  put_on_plane(site);
}

/// Two peers in agreement, past their ramps.
std::unique_ptr<Session> agreed(int profile, const Build& build, const pbd::WorldDef& def,
                                const PeerOptions& options = {}) {
  auto session = std::make_unique<Session>(network_profile(profile));
  build(session->add(1, 0.0, options, def));
  build(session->add(2, 0.007, options, def));
  session->run(kSettled);
  return session;
}

TEST_CASE("peer: 10 cm of disagreement halve within 20 frames and vanish, profile 5",
          "[consensus]") {
  const bool resting = GENERATE(false, true);
  const bool far_peer = GENERATE(false, true);
  CAPTURE(resting, far_peer);
  const auto session = resting ? agreed(5, resting_cube, {}) : agreed(5, free_ball, kWeightless);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  (far_peer ? b : a).displace({0.06, 0.08, 0.0});
  REQUIRE(gap(a, b) == Approx(0.1).margin(1e-4));
  session->run(20.0 * kFrame);
  UNSCOPED_INFO("left after 20 frames: " << gap(a, b));
  CHECK(gap(a, b) < 0.05);
  session->run(2.0);
  CHECK(gap(a, b) < 1e-3);
  // Nobody owns it: they meet somewhere between.
  CHECK(a.x().head<2>().norm() > 0.02);
  CHECK(a.x().head<2>().norm() < 0.08);
  if (resting) CHECK(std::abs(a.x().z() - kHalf.z()) < 1e-3);
}

TEST_CASE("peer: a disagreement about velocity halves within 20 frames, profile 5", "[consensus]") {
  const auto session = agreed(5, free_ball, kWeightless);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  b.world.set_twist(b.body, {Vec3(0.3, 0.0, 0.4), Vec3(0.0, 2.0, 0.0)});
  session->run(20.0 * kFrame);
  CHECK((a.v() - b.v()).norm() < 0.25);
  CHECK((a.twist().angular - b.twist().angular).norm() < 1.0);
  session->run(2.7);
  CHECK((a.v() - b.v()).norm() < 1e-3);
  CHECK(gap_now(a, b) < 1e-3);
  // They meet between.
  CHECK(a.v().norm() > 0.1);
  CHECK(a.v().norm() < 0.4);
}

TEST_CASE("peer: a fast spin is no disagreement about orientation", "[consensus]") {
  // 12 rad/s are 85 degrees within the age of an update. Were that taken for one, the lower id
  // would lead and not move.
  const auto session = agreed(
      5,
      [](Site& site) {
        pbd::BodyDef def = ball(Vec3::Zero());
        const double angle = site.id == 2 ? 12.0 * 0.007 : 0.0;
        def.pose.orientation = Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()));
        def.twist.angular = Vec3(0.0, 0.0, 12.0);
        site.share(def);
      },
      kWeightless);
  Site& a = (*session)[0];
  Site& b = (*session)[1];
  b.displace({0.05, 0.0, 0.0});
  session->run(2.0);
  CHECK(gap(a, b) < 1e-3);
  CHECK(a.x().x() > 0.01);
  CHECK(a.x().x() < 0.04);
  CHECK(a.twist().angular.z() == Approx(12.0).epsilon(1e-3));
}

TEST_CASE("peer: symmetric exchange without delay adds no kinetic energy", "[consensus]") {
  const auto predictor = GENERATE(PredictorKind::Replay, PredictorKind::Euler);
  const int count = GENERATE(2, 4);
  Dice dice(7);
  Session session;
  PeerOptions options{.predictor = predictor, .authority_ramp = 0.0};
  CAPTURE(static_cast<int>(predictor), count);
  options.robust.outvote = false;  // it is not symmetric: the fewer follow the others
  options.replay.tolerance = 0.0;  // nor is it that one peer leaves alone what another does not
  for (int i = 0; i < count; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.0, options, kWeightless);
    pbd::BodyDef def = ball(dice.vec3(0.05), dice.vec3(2.0));
    def.pose.orientation = dice.rotation(0.2);
    def.twist.angular = dice.vec3(2.0);
    site.share(def);
  }
  const auto energy = [&] {
    double sum = 0.0;
    for (const auto& site : session.sites) sum += site->world.kinetic_energy();
    return sum;
  };
  // Velocities travel as 32-bit floats, off by up to 2^-24 each way: with less than a third of them
  // exchanged in a frame, energy may rise by 4e-8 of itself in one, and less over many.
  const double first = energy();
  double last = first;
  double lowest = first;
  double rise = 0.0;
  double total_rise = 0.0;
  for (int frame = 0; frame < 200; ++frame) {
    session.run(kFrame);
    const double now = energy();
    rise = std::max(rise, now / last - 1.0);
    total_rise = std::max(total_rise, now / lowest - 1.0);
    last = now;
    lowest = std::min(lowest, now);
  }
  CHECK(rise < 4e-8);
  CHECK(total_rise < 2e-7);
  // It has something to do: opposed parts of the velocities have met.
  CHECK(last < 0.9 * first);
}

/// Holds the shared body by a spring to where it is; the first peer's user does.
Build spring_held(double stiffness, double damping) {
  return [=](Site& site) {
    free_ball(site);
    if (site.id != 1) return;
    site.peer->grab({.body = kBody, .stiffness = stiffness, .damping = damping});
  };
}

TEST_CASE("peer: a difference does not grow at any delay", "[consensus]") {
  struct Scene {
    const char* name;
    Build build;
    pbd::WorldDef def;
  };
  const int profile = GENERATE(1, 2, 3, 4, 5);
  const std::array scenes{
      Scene{"free", free_ball, kWeightless},
      Scene{"resting", resting_cube, {}},
      Scene{"spring, 3.6 Hz", spring_held(500.0, 20.0), kWeightless},
      Scene{"spring, 8 Hz, critically damped", spring_held(2500.0, 100.0), kWeightless},
  };
  for (const Scene& scene : scenes) {
    INFO(scene.name << ", profile " << profile);
    const auto session = agreed(profile, scene.build, scene.def);
    Site& a = (*session)[0];
    Site& b = (*session)[1];
    b.displace({0.02, 0.0, 0.0});
    double before = 0.02;
    for (int part = 0; part < 4; ++part) {
      double largest = 0.0;
      for (int frame = 0; frame < 30; ++frame) {
        session->run(kFrame);
        largest = std::max(largest, gap(a, b));
      }
      // The rest after each half second is less than before, down to nothing visible.
      CHECK(largest <= std::max(before * (1.0 + 1e-6), 1e-5));
      before = largest;
    }
    CHECK(before < 1e-3);
    CHECK(a.v().norm() < 5e-3);
    CHECK(b.v().norm() < 5e-3);
  }
}

TEST_CASE("peer: two-step coupling leaves less than 1 mm alone and averages more by the share",
          "[consensus]") {
  const PeerOptions options{.coupling = Coupling::TwoStep, .authority_ramp = 0.0};
  Session session;
  free_ball(session.add(1, 0.0, options, kWeightless));
  free_ball(session.add(2, 0.0, options, kWeightless));
  session.run(0.5);
  Site& a = session[0];
  Site& b = session[1];

  b.displace({0.9e-3, 0.0, 0.0});
  b.world.set_twist(b.body, {Vec3(0.0, 9e-3, 0.0), Vec3(0.0, 0.0, 9e-3)});
  const Twist slow = b.twist();
  session.run(2.0 * kFrame);
  CHECK(b.v() == slow.linear);
  CHECK(b.twist().angular == slow.angular);
  CHECK(b.x().x() == 0.9e-3);
  CHECK(a.x() == Vec3(0.0, 0.0, 0.0));

  b.world.set_twist(b.body, {});
  b.world.set_pose(b.body, {Vec3(0.02, 0.0, 0.0), Quat::Identity()});
  session.run(kFrame);  // stamped and sent
  // The step over which b was moved by hand is no news to b: its own history says so.
  const double before = b.x().x() - a.x().x();
  session.run(kFrame);
  // Both close the closing share of what they miss of the mean, half of the gap.
  CHECK(b.x().x() - a.x().x() == Approx(before * (1.0 - ReplayOptions{}.share)).epsilon(1e-6));
  // Positions are put, velocities know nothing of it.
  CHECK(a.v().norm() == 0.0);
  CHECK(b.v().norm() == 0.0);
}

TEST_CASE("peer: cubes resting on different faces agree within 3 s, the lower id leads",
          "[consensus]") {
  const int profile = GENERATE(2, 5);
  const int turned_peer = GENERATE(0, 1);
  const bool from_the_start = GENERATE(true, false);
  CAPTURE(profile, turned_peer, from_the_start);
  Session session(network_profile(profile));
  const Quat over(Eigen::AngleAxisd(0.5 * kPi, Vec3::UnitY()));
  for (int i = 0; i < 2; ++i) {
    Site& site = session.add(static_cast<PeerId>(i + 1), 0.007 * i);
    const bool turned = i == turned_peer && from_the_start;
    site.share(cube({0.0, 0.0, kHalf.z()}, turned ? over : Quat(Quat::Identity())));
    put_on_plane(site);
  }
  Site& a = session[0];
  Site& b = session[1];
  if (!from_the_start) {
    session.run(kSettled);
    Site& site = session[static_cast<std::size_t>(turned_peer)];
    site.world.set_pose(site.body, {site.x(), over * site.pose().orientation});
  }
  const Quat lead = a.pose().orientation;
  double led_astray = 0.0;
  session.after = [&](Site& site) {
    if (&site != &a) return;
    led_astray = std::max(led_astray, tandem::testing::angle_between(lead, a.pose().orientation));
  };
  session.run(3.0);
  const double degree = kPi / 180.0;
  CHECK(tandem::testing::angle_between(a.pose().orientation, b.pose().orientation) < 1.0 * degree);
  CHECK(led_astray < 20.0 * degree);
  CHECK(std::abs(a.x().z() - kHalf.z()) < 1e-3);
  CHECK(std::abs(b.x().z() - kHalf.z()) < 1e-3);
}

}  // namespace
}  // namespace tandem::consensus::peer_agreement_test
