// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Peers come in the middle of things, leave, crash, lose each other and start again.
#include <algorithm>
#include <cmath>
#include <map>

#include "consensus/crowd_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::membership_test {
namespace {

using namespace testing;

/// m: how much further a body moved in a step than its velocity says.
class Pops {
 public:
  void look(const Member& member) {
    for (std::size_t body = 0; body < member.bodies.size(); ++body) {
      Last& last = last_[{&member, body}];
      const Vec3& x = member.x(body);
      const double speed = std::max(member.v(body).norm(), last.v.norm());
      if (last.known) most = std::max(most, (x - last.x).norm() - speed * kTick);
      last = {x, member.v(body), true};
    }
  }
  void forget() { last_.clear(); }
  double most = 0.0;

 private:
  struct Last {
    Vec3 x = Vec3::Zero();
    Vec3 v = Vec3::Zero();
    bool known = false;
  };
  std::map<std::pair<const Member*, std::size_t>, Last> last_;
};

double widest(const Crowd& crowd) {
  return std::max({spread(crowd, kCube), spread(crowd, kFree), spread(crowd, kCarried)});
}

TEST_CASE("membership: a newcomer in mid-action agrees within a second, unnoticed by the others",
          "[consensus]") {
  const int profile = GENERATE(1, 3, 5);
  const PeerId late = GENERATE(PeerId{1}, PeerId{9});
  Crowd crowd(network_profile(profile));
  crowd.build = build_table;
  for (PeerId id = 2; id <= 3; ++id) crowd.add(id);
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  crowd.run(2.5);
  // Differences between peers while something is carried: steps 1 ms apart, and latency.
  double usual = 0.0;
  crowd.after = [&](Member&) { usual = std::max(usual, widest(crowd)); };
  crowd.run(2.0);
  Pops established;
  Pops newcomer;
  crowd.add(late);
  const Member* const fresh = crowd.members.back().get();
  const double placed = network_profile(profile).latency + network_profile(profile).jitter + 0.05;
  const SessionTime arrival = crowd.now();
  double after_a_second = 0.0;
  crowd.after = [&](Member& member) {
    const double t = 1e-9 * static_cast<double>(member.next - arrival);
    if (&member != fresh) established.look(member);
    if (&member == fresh && t > placed) newcomer.look(member);
    if (t > 1.0) after_a_second = std::max(after_a_second, widest(crowd));
  };
  crowd.run(4.0);
  INFO("profile " << profile << ", id " << late << ": pops " << 1e3 * established.most << " and "
                  << 1e3 * newcomer.most << " mm, apart " << 1e3 * after_a_second << " mm, usually "
                  << 1e3 * usual);
  CHECK(established.most < 5e-3);
  CHECK(newcomer.most < 5e-3);
  CHECK(after_a_second < 1.5 * usual + 1e-3);
  CHECK(fresh->tethers() == 1);
}

TEST_CASE("membership: a crash in mid-lift leaves no spring anywhere, nor does leaving",
          "[consensus]") {
  const bool says_so = GENERATE(true, false);
  Crowd crowd(network_profile(4));
  crowd.build = build_table;
  for (PeerId id = 1; id <= 4; ++id) crowd.add(id);
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  crowd.run(3.0);
  for (const auto& member : crowd.members) CHECK(member->tethers() == 1);
  CHECK(crowd[2].x(kCarried).z() > 0.3);
  if (says_so) crowd[0].peer->leave(crowd.now());
  crowd.crash(crowd[0]);
  // A farewell takes its way; silence is noticed after the timeout.
  crowd.run(says_so ? 0.2 : PeerOptions{}.spring_timeout + 0.2);
  for (std::size_t i = 1; i < 4; ++i) CHECK(crowd[i].tethers() == 0);
  crowd.run(3.0);
  for (std::size_t i = 1; i < 4; ++i) {
    CHECK_FALSE(crowd[i].peer->held(crowd[i].bodies[kCarried].id));
    CHECK(crowd[i].x(kCarried).z() == Approx(kBallRadius).margin(2e-3));
  }
  CHECK(widest(crowd) < 5e-3);
}

TEST_CASE("membership: a peer that restarts in mid-lift under its id takes part again",
          "[consensus]") {
  const double pause = GENERATE(0.05, 0.5, 3.0);
  const int profile = GENERATE(1, 5);
  Crowd crowd(network_profile(profile));
  crowd.build = build_table;
  for (PeerId id = 1; id <= 3; ++id) crowd.add(id);
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  crowd.run(3.0);
  crowd.crash(crowd[0]);
  crowd.run(pause);
  double fastest = 0.0;
  Pops others;
  crowd.after = [&](Member& member) {
    for (std::size_t body = 0; body < 3; ++body) {
      fastest = std::max(fastest, member.v(body).norm());
    }
    if (&member != &crowd[0]) others.look(member);
  };
  // Its user takes the body again, wherever it is now.
  crowd[0].user = nullptr;
  crowd.restart(crowd[0]);
  crowd.run(1.5);
  INFO("pause " << pause << " s, profile " << profile << ": fastest " << fastest << " m/s, pops "
                << 1e3 * others.most << " mm, apart " << 1e3 * widest(crowd) << " mm");
  CHECK(others.most < 5e-3);
  // At profile 5 it falls at 3 m/s where some know by 10 ms earlier that the hand has gone.
  CHECK(widest(crowd) < (profile == 5 ? 0.035 : 0.02));
  for (const auto& member : crowd.members) CHECK(member->tethers() == 0);
  const GrabId grab = crowd[0].peer->grab({.body = crowd[0].bodies[kCarried].id,
                                           .anchor_w = crowd[0].x(kCarried) + Vec3(0.0, 0.0, 0.4),
                                           .stiffness = 300.0,
                                           .damping = 25.0,
                                           .max_force = 50.0});
  crowd.run(2.0);
  for (const auto& member : crowd.members) CHECK(member->tethers() == 1);
  CHECK(crowd[2].x(kCarried).z() > 0.3);
  CHECK(widest(crowd) < 2e-3);
  crowd[0].peer->release(grab);
  crowd.run(0.5);
  for (const auto& member : crowd.members) CHECK(member->tethers() == 0);
  // It fell at most from the carrier's height, and was carried at 1 m/s.
  CHECK(fastest < 5.0);
}

TEST_CASE("membership: two halves that were apart for ten seconds come together", "[consensus]") {
  const int profile = GENERATE(1, 5);
  const std::size_t half = GENERATE(std::size_t{1}, std::size_t{2});
  Crowd crowd(network_profile(profile));
  crowd.build = build_table;
  for (PeerId id = 1; id <= 4; ++id) crowd.add(id);
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  double usual = 0.0;
  crowd.after = [&](Member& member) {
    if (member.next > kStart + ns(1.5)) usual = std::max(usual, widest(crowd));
  };
  crowd.run(3.0);
  crowd.after = nullptr;
  const auto each_pair = [&](auto&& what) {
    for (std::size_t a = 0; a < half; ++a) {
      for (std::size_t b = half; b < 4; ++b) {
        what(crowd[a].transport.self(), crowd[b].transport.self());
        what(crowd[b].transport.self(), crowd[a].transport.self());
      }
    }
  };
  each_pair([&](PeerId from, PeerId to) { crowd.network.cut(from, to); });
  // Meanwhile both sides move things.
  GrabId other;
  crowd[3].user = [&](Member& member, SessionTime now) {
    if (now < kStart + ns(4.0)) return;
    if (other == GrabId{}) {
      other = member.peer->grab({.body = member.bodies[kCube].id,
                                 .anchor_w = Vec3(0.0, 0.8, kHalf.z()),
                                 .stiffness = 100.0,
                                 .damping = 20.0,
                                 .max_force = 20.0});
    }
  };
  crowd.run(10.0);
  const double apart = widest(crowd);
  CHECK(apart > 0.3);
  double fastest = 0.0;
  double corrected = 0.0;
  crowd.after = [&](Member& member) {
    for (std::size_t body = 0; body < 3; ++body) {
      fastest = std::max(fastest, member.v(body).norm());
      corrected = std::max(corrected,
                           member.world->correction(member.bodies[body].body).translation.norm());
    }
  };
  each_pair([&](PeerId from, PeerId to) { crowd.network.heal(from, to); });
  crowd.run(3.0);
  INFO("profile " << profile << ", " << half << " alone: " << apart << " m apart, then fastest "
                  << fastest << " m/s, corrected by " << 1e3 * corrected << " mm, then apart "
                  << 1e3 * widest(crowd) << " mm");
  CHECK(corrected <= 1.01 * RobustOptions{}.max_correction);
  CHECK(widest(crowd) < usual + 1e-3);
  // Speed from users' springs: 0.9 m/s carried around, 20 N over 0.8 m.
  CHECK(fastest < 6.0);
  for (const auto& member : crowd.members) CHECK(member->tethers() == 2);
}

}  // namespace
}  // namespace tandem::consensus::membership_test
