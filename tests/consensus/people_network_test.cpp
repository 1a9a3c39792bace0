// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One of four has a network, or a machine, as people have them: what the other three see of it, and
// when it is with them again.
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "consensus/crowd_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace tandem::consensus::people_network_test {
namespace {

using namespace testing;

constexpr std::size_t kHis = 3;      ///< of the four
constexpr std::size_t kAdrift = 40;  ///< balls more, so that a replay of a second is beyond budgets

constexpr std::size_t kStill = kCarried + 1;

/// The trouble of one member, from 2 s to 8 s.
struct Trouble {
  std::string name;
  std::function<void(Crowd&)> begin;
  std::function<void(Crowd&)> end = [](Crowd&) {};
};

void set_links(Crowd& crowd, const LinkOptions& up, const LinkOptions& down) {
  const PeerId him = crowd[kHis].transport.self();
  for (PeerId other = 1; other < him; ++other) {
    crowd.network.set_link(him, other, up);
    crowd.network.set_link(other, him, down);
  }
}

std::vector<Trouble> troubles() {
  std::vector<Trouble> out;
  for (const NamedNetwork& network : named_networks()) {
    out.push_back(
        {.name = std::string(network.name),
         .begin = [&](Crowd& crowd) { set_links(crowd, network.up, network.down); },
         .end = [](Crowd& crowd) { set_links(crowd, network_profile(2), network_profile(2)); }});
  }
  const auto with = [](double dt, double pace) {
    return [=](Crowd& crowd) {
      crowd[kHis].dt = dt;
      crowd[kHis].pace = pace;
    };
  };
  out.push_back(
      {.name = "15 steps a second", .begin = with(4 * kTick, 1.0), .end = with(kTick, 1.0)});
  out.push_back({.name = "half of real time", .begin = with(kTick, 0.5), .end = with(kTick, 1.0)});
  out.push_back(
      {.name = "a locked phone", .begin = [](Crowd& crowd) { crowd[kHis].next += ns(6.0); }});
  return out;
}

void build(Member& member) {
  build_table(member);
  for (std::size_t i = 0; i < kAdrift; ++i) {
    pbd::BodyDef adrift =
        ball({static_cast<double>(i), 5.0, 1.0}, {0.0, 0.02 * static_cast<double>(i % 5), 0.0});
    adrift.gravity_scale = 0.0;
    member.share("adrift " + std::to_string(i), adrift);
  }
}

/// He moves the ball that nothing holds at 1 m/s, with a hand that nobody foresees.
struct Waver {
  pbd::SplitMix64 dice;
  GrabId grab = {};
  Vec3 aim = Vec3::Zero();
  Vec3 way = Vec3::Zero();
  int steps = 0;
  void operator()(Member& member, SessionTime now) {
    if (steps++ % 20 == 0) aim = Vec3(dice.unit() - 0.5, dice.unit() - 0.5, dice.unit() - 0.5);
    way += (aim - way) * std::min(1.0, member.dt / std::max(1e-9, (aim - way).norm()));
    const Vec3 at = Vec3(2.0, 0.0, 1.0) + way;
    if (grab == GrabId{}) {
      grab = member.peer->grab({.body = member.bodies[kFree].id,
                                .anchor_w = at,
                                .stiffness = 100.0,
                                .damping = 15.0,
                                .max_force = 50.0});
    }
    member.peer->move(grab, at, now);
  }
};

/// Meanwhile somebody pulls the cube along and lets it go.
struct Puller {
  GrabId grab = {};
  bool done = false;
  void operator()(Member& member, SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart) - 3.0;
    if (t < 0.0 || done) return;
    done = t > 3.0;
    if (done) return member.peer->release(grab);
    const Vec3 at(-0.5 * std::min(t, 1.0), 0.0, kHalf.z());
    if (grab == GrabId{}) {
      grab = member.peer->grab({.body = member.bodies[kCube].id,
                                .anchor_w = at,
                                .stiffness = 300.0,
                                .damping = 25.0,
                                .max_force = 50.0});
    }
    member.peer->move(grab, at, now);
  }
};

/// m, largest distance between two of the first `count` members' copies, at the same time.
double apart(const Crowd& crowd, std::size_t body, std::size_t count) {
  double most = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const Member& a = *crowd.members[i];
      const Member& b = *crowd.members[k];
      const double ahead = 1e-9 * static_cast<double>(a.next - b.next);
      most = std::max(most, (a.x(body) - (b.x(body) + ahead * b.v(body))).norm());
    }
  }
  return most;
}

struct Outcome {
  double others = 0.0;  ///< m, of the carried body, among the other three
  double apart = 0.0;   ///< m, of his ball, among all, in the trouble
  double moved = 0.0;   ///< m, of both, from 1 s after it on
  double rested = 0.0;  ///< m, of the cube, which was pulled along meanwhile, likewise
  double still = 0.0;   ///< m, of a ball that nothing has moved, from 0.3 s after it on
};

Outcome run(std::uint64_t seed, const Trouble* trouble) {
  Crowd crowd(network_profile(2), seed);
  crowd.build = build;
  for (PeerId id = 1; id <= 4; ++id) crowd.add(id);
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  Puller puller;
  crowd[1].user = [&](Member& member, SessionTime now) { puller(member, now); };
  Waver waver{.dice = pbd::SplitMix64(seed)};
  crowd[kHis].user = [&](Member& member, SessionTime now) { waver(member, now); };
  Outcome out;
  crowd.tick = [&](SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    if (t > 2.0) out.others = std::max(out.others, apart(crowd, kCarried, kHis));
    if (t > 2.0 && t < 8.0) out.apart = std::max(out.apart, apart(crowd, kFree, 4));
    if (t > 9.0) {
      out.moved = std::max({out.moved, apart(crowd, kCarried, 4), apart(crowd, kFree, 4)});
    }
    if (t > 9.0) out.rested = std::max(out.rested, apart(crowd, kCube, 4));
    if (t > 8.3) out.still = std::max(out.still, apart(crowd, kStill, 4));
  };
  crowd.run(2.0);
  if (trouble != nullptr) trouble->begin(crowd);
  crowd.run(6.0);
  if (trouble != nullptr) trouble->end(crowd);
  crowd.run(4.0);
  CHECK(crowd[0].x(kCube).x() < -0.3);
  return out;
}

TEST_CASE("people's networks: a bad one disturbs no other peer and ends within 1 s",
          "[consensus][fault][long]") {
  const std::uint64_t seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{4}));
  const Outcome without = run(seed, nullptr);
  for (const Trouble& trouble : troubles()) {
    const Outcome with = run(seed, &trouble);
    INFO(trouble.name << ", seed " << seed << ": others " << 1e3 * with.others << " mm ("
                      << 1e3 * without.others << "), his ball " << 1e3 * with.apart << " ("
                      << 1e3 * without.apart << "), moved " << 1e3 * with.moved << " ("
                      << 1e3 * without.moved << "), rested " << 1e3 * with.rested << ", still "
                      << 1e3 * with.still);
    CHECK(with.others < 1.5 * without.others + 1e-3);
    CHECK(with.moved < 1.5 * without.moved + 1e-3);
    CHECK(with.rested < 1e-3);
    CHECK(with.still < 1e-3);
  }
}

}  // namespace
}  // namespace tandem::consensus::people_network_test
