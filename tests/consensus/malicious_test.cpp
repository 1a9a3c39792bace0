// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One member lies, in its own name and well formed. The others' poses are compared with those of
// the same session in which it says nothing.
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "consensus/crowd_fixture.h"
#include "consensus/random.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus::malicious_test {
namespace {

using namespace testing;

/// The lowest id, which leads where nothing else decides.
constexpr PeerId kLiar = 1;

/// Its claim about one body to one other peer: it changes the true state (that of the first honest
/// peer).
using Lie = std::function<void(StateUpdate& update, PeerId to, double t, Dice& dice)>;

struct Trace {
  std::vector<Vec3> at;             ///< m, of all honest peers' bodies, after each of their steps
  std::vector<PeerReport> reports;  ///< of the liar, at the honest peers
  double apart = 0.0;               ///< m, at the end, largest distance between honest copies
};

Trace run(int honest, const Lie& lie, int profile, double seconds = 4.0) {
  Crowd crowd(network_profile(profile));
  Transport& liar = crowd.network.transport(kLiar);
  crowd.build = build_table;
  for (int i = 0; i < honest; ++i) crowd.add(static_cast<PeerId>(i + 2));
  Carrier carrier;
  crowd[0].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  Trace trace;
  crowd.after = [&](Member& member) {
    for (std::size_t body = 0; body < member.bodies.size(); ++body) {
      trace.at.push_back(member.x(body));
    }
  };
  Dice dice(7);
  std::vector<StateUpdate> says;
  std::vector<std::byte> bytes;
  crowd.tick = [&](SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart) - 1.5;
    if (!lie || t < 0.0) return;
    const Member& truth = crowd[0];
    for (const auto& to : crowd.members) {
      says.clear();
      for (const Member::Body& body : truth.bodies) {
        StateUpdate update{.id = body.id,
                           .pose = truth.world->pose(body.body),
                           .twist = truth.world->twist(body.body),
                           .influence = 0.08F,
                           .stamp = now};
        lie(update, to->transport.self(), t, dice);
        says.push_back(update);
      }
      bytes.clear();
      encode(says, bytes);
      if (!bytes.empty()) liar.post(to->transport.self(), bytes, Delivery::Newest);
    }
  };
  crowd.run(1.5 + seconds);
  for (std::size_t body = 0; body < 3; ++body)
    trace.apart = std::max(trace.apart, spread(crowd, body));
  for (const auto& member : crowd.members) {
    for (const PeerReport& report : member->peer->reports()) {
      if (report.peer == kLiar) trace.reports.push_back(report);
    }
  }
  return trace;
}

/// m, of each body (cube at rest, free ball, carried ball): how far it moved any honest peer's.
std::array<double, 3> moved(const Trace& with, const Trace& without) {
  std::array<double, 3> most{};
  REQUIRE(with.at.size() == without.at.size());
  for (std::size_t i = 0; i < with.at.size(); ++i) {
    const double by = (with.at[i] - without.at[i]).norm();
    REQUIRE(std::isfinite(by));
    most[i % 3] = std::max(most[i % 3], by);
  }
  return most;
}

struct Named {
  const char* name;
  Lie lie;
  bool noticed;  ///< it is in the reports
};

const Vec3 kAside(1.0, 0.0, 0.0);

std::vector<Named> all_lies() {
  return {
      {"constant offset", [](auto& u, PeerId, double, Dice&) { u.pose.position += kAside; }, true},
      {"small offset", [](auto& u, PeerId, double, Dice&) { u.pose.position += 0.03 * kAside; },
       false},
      {"swings",
       [](auto& u, PeerId, double t, Dice&) {
         u.pose.position += 0.5 * std::sin(20.0 * t) * kAside;
         u.twist.linear += 10.0 * std::cos(20.0 * t) * kAside;
       },
       true},
      {"drifts",
       [](auto& u, PeerId, double t, Dice&) {
         u.pose.position += 0.1 * t * kAside;
         u.twist.linear += 0.1 * kAside;
       },
       true},
      {"teleports",
       [](auto& u, PeerId, double, Dice& dice) {
         u.pose.position += dice.vec3(5.0);
         u.flags.teleported = true;
       },
       true},
      {"leads, owns, holds",
       [](auto& u, PeerId, double, Dice&) {
         u.pose.position += 0.3 * kAside;
         u.influence = 1.0F;
         u.flags.leads = u.flags.held = u.flags.owner_driven = true;
       },
       true},
      {"from the future",
       [](auto& u, PeerId, double, Dice&) {
         u.pose.position += 0.3 * kAside;
         u.stamp += ns(0.9);
       },
       true},
      {"from the past",
       [](auto& u, PeerId, double, Dice&) {
         u.pose.position += 0.3 * kAside;
         u.stamp -= ns(0.5);
       },
       true},
      {"to each something else",
       [](auto& u, PeerId to, double, Dice&) {
         u.pose.position += (to % 2 == 0 ? 0.3 : -0.3) * kAside;
       },
       true},
      {"velocities",
       [](auto& u, PeerId, double, Dice&) {
         u.twist.linear += 50.0 * kAside;
         u.twist.angular += 300.0 * Vec3::UnitZ();
       },
       true},
      {"on its other side",
       [](auto& u, PeerId, double, Dice&) {
         u.pose.orientation = Quat(Eigen::AngleAxisd(3.0, Vec3::UnitX())) * u.pose.orientation;
       },
       true},
      {"numbers at the end of their range",
       [](auto& u, PeerId, double, Dice& dice) {
         u.pose.position = 0.99 * kMaxPosition * dice.direction();
         u.twist.linear = 0.99 * kMaxLinearSpeed * dice.direction();
         u.twist.angular = 0.99 * kMaxAngularSpeed * dice.direction();
         u.influence = 1.0F;
       },
       true},
  };
}

TEST_CASE("malicious: one liar of four moves nothing", "[consensus][fault]") {
  const int profile = GENERATE(1, 5);
  const Trace alone = run(3, {}, profile);
  for (const Named& lie : all_lies()) {
    const Trace trace = run(3, lie.lie, profile);
    const std::array<double, 3> by = moved(trace, alone);
    INFO("profile " << profile << ", " << lie.name << ": cube " << 1e3 * by[0] << " mm, free "
                    << 1e3 * by[1] << " mm, carried " << 1e3 * by[2] << " mm; honest apart "
                    << 1e3 * trace.apart << " mm beside " << 1e3 * alone.apart);
    CHECK(by[0] < 1e-3);
    CHECK(by[1] < 1e-3);
    CHECK(by[2] < 1e-2);
    std::uint64_t noticed = 0;
    for (const PeerReport& report : trace.reports) {
      noticed += report.outliers + report.inbox.implausible + report.unfounded_leads +
                 report.influence_cut + report.inbox.future + report.capped + report.late;
    }
    if (lie.noticed) CHECK(noticed > 100);
    CHECK(trace.apart < alone.apart + 1e-2);
  }
}

TEST_CASE("malicious: one liar of three moves nothing either, while it says the same to both",
          "[consensus][fault]") {
  const Trace alone = run(2, {}, 3);
  for (const Named& lie : all_lies()) {
    const std::array<double, 3> by = moved(run(2, lie.lie, 3), alone);
    INFO(lie.name << ": cube " << 1e3 * by[0] << " mm, free " << 1e3 * by[1] << " mm, carried "
                  << 1e3 * by[2] << " mm");
    CHECK(by[0] < 1e-3);
    CHECK(by[1] < 1e-3);
    CHECK(by[2] < 2e-2);
  }
}

TEST_CASE("malicious: of two, a liar asks for no more than the limit in a step",
          "[consensus][fault]") {
  PeerOptions options;
  options.robust.max_correction = 0.02;
  Crowd crowd;
  Transport& liar = crowd.network.transport(kLiar);
  crowd.build = build_table;
  Member& honest = crowd.add(2, options);
  double most = 0.0;
  crowd.after = [&](Member& member) {
    most = std::max(most, member.world->correction(member.bodies[kFree].body).translation.norm());
  };
  crowd.tick = [&](SessionTime now) {
    StateUpdate update{.id = honest.bodies[kFree].id,
                       .pose = {{2.0 + 10.0, 0.0, 1.0}, Quat::Identity()},
                       .influence = 1.0F,
                       .stamp = now};
    std::vector<std::byte> bytes;
    encode(std::span(&update, 1), bytes);
    // Not heard as a newcomer hears, who takes over all there is.
    if (now > kStart + ns(1.5)) liar.post(2, bytes, Delivery::Newest);
  };
  crowd.run(3.0);
  CHECK(most > 0.019);
  CHECK(most < 0.02 * 1.01);
  REQUIRE(honest.peer->reports().size() == 1);
  CHECK(honest.peer->reports()[0].capped > 80);
}

TEST_CASE("malicious: of two, a liar turns and throws by no more than the limits in a step",
          "[consensus][fault]") {
  PeerOptions options;
  options.predictor = GENERATE(PredictorKind::Euler, PredictorKind::Replay);
  options.robust.max_turn = 0.02;
  options.robust.max_velocity_correction = 0.05;
  Crowd crowd;
  Transport& liar = crowd.network.transport(kLiar);
  crowd.build = build_table;
  Member& honest = crowd.add(2, options);
  double turned = 0.0, thrown = 0.0;
  Vec3 before = Vec3::Zero();
  crowd.after = [&](Member& member) {
    const pbd::BodyId body = member.bodies[kFree].body;
    turned = std::max(turned, member.world->correction(body).rotation.norm());
    const Vec3 now = member.world->twist(body).linear;
    thrown = std::max(thrown, now.x() - before.x());
    before = now;
  };
  crowd.tick = [&](SessionTime now) {
    const pbd::Pose& true_pose = honest.world->pose(honest.bodies[kFree].body);
    StateUpdate update{
        .id = honest.bodies[kFree].id,
        .pose = {true_pose.position, pbd::exp_map(2.0 * Vec3::UnitZ()) * true_pose.orientation},
        .twist = {Vec3(9.0, 0.0, 0.0), Vec3::Zero()},
        .influence = 1.0F,
        .stamp = now};
    std::vector<std::byte> bytes;
    encode(std::span(&update, 1), bytes);
    // Not heard as a newcomer hears, who takes over all there is.
    if (now > kStart + ns(1.5)) liar.post(2, bytes, Delivery::Newest);
  };
  crowd.run(3.0);
  CHECK(turned > 0.019);
  CHECK(turned < 0.02 * 1.01);
  CHECK(thrown > 0.02);
  CHECK(thrown < 0.05 * 1.01);
}

TEST_CASE("malicious: springs that no hand could pull are limited, refused and counted",
          "[consensus][fault]") {
  Crowd crowd(network_profile(2));
  Transport& liar = crowd.network.transport(kLiar);
  crowd.build = build_table;
  for (int i = 0; i < 3; ++i) crowd.add(static_cast<PeerId>(i + 2));
  double fastest = 0.0;
  crowd.after = [&](Member& member) {
    for (std::size_t body = 0; body < 3; ++body) {
      fastest = std::max(fastest, member.v(body).norm());
      REQUIRE(member.x(body).allFinite());
    }
  };
  std::uint32_t number = 1000;
  std::vector<std::byte> bytes;
  crowd.tick = [&](SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    if (t < 1.5 || t > 4.0) return;
    std::vector<SpringUpdate> springs;
    const auto pull = [&](std::uint32_t spring, const Vec3& anchor, double stiffness) {
      springs.push_back({.spring = spring,
                         .revision = 1,
                         .event = SpringEvent::Create,
                         .body = crowd[0].bodies[kFree].id,
                         .anchor_w = anchor,
                         .anchor_velocity = Vec3(9e4, 0.0, 0.0),
                         .stiffness = stiffness,
                         .damping = 9e11,
                         .max_force = 9e11,
                         .stamp = now});
    };
    pull(1, {1e6, 0.0, 0.0}, 9e11);
    pull(2, {2.0, 3.0, 1.0}, 9e11);
    for (int i = 0; i < 50; ++i) pull(number++, {2.0, -2.0, 1.0}, 1e3);
    bytes.clear();
    encode(springs, bytes);
    for (const auto& to : crowd.members) liar.post(to->transport.self(), bytes, Delivery::Reliable);
  };
  crowd.run(4.0);
  INFO("fastest " << fastest << " m/s");
  // No faster than the hands may make it, and what agreement adds.
  CHECK(fastest < 1.5 * RobustOptions{}.max_pull_speed);
  for (const auto& member : crowd.members) {
    CHECK(member->tethers() <= RobustOptions{}.max_springs_per_body);
    const auto reports = member->peer->reports();
    const auto found = std::find_if(reports.begin(), reports.end(),
                                    [](const PeerReport& r) { return r.peer == kLiar; });
    REQUIRE(found != reports.end());
    CHECK(found->springs_refused > 1000);
    CHECK(found->springs_limited > 50);
  }
  // It falls silent: all is let go, and what it threw is where all see it.
  crowd.run(2.0);
  for (const auto& member : crowd.members) CHECK(member->tethers() == 0);
  crowd.run(2.0);
  CHECK(spread(crowd, kFree) < 0.01 * crowd.members[0]->v(kFree).norm() + 1e-3);
}

TEST_CASE("malicious: a hand beyond max_reach holds nothing", "[consensus][fault]") {
  const double reach = GENERATE(2.0, 5.0);
  PeerOptions options;
  options.robust.max_reach = reach;
  Crowd crowd;
  Transport& liar = crowd.network.transport(kLiar);
  crowd.build = build_table;
  Member& member = crowd.add(2, options);
  crowd.tick = [&](SessionTime now) {
    const SpringUpdate spring{.spring = 1,
                              .revision = 1,
                              .event = SpringEvent::Create,
                              .body = member.bodies[kFree].id,
                              .anchor_w = Vec3(2.0, 3.0, 1.0),
                              .stiffness = 0.1,
                              .damping = 0.1,
                              .max_force = 0.1,
                              .stamp = now};
    std::vector<std::byte> bytes;
    encode(std::span(&spring, 1), bytes);
    liar.post(2, bytes, Delivery::Reliable);
  };
  crowd.run(1.0);
  // The hand is 3 m from the ball.
  CHECK(member.tethers() == (reach > 3.0 ? 1 : 0));
  CHECK((member.v(kFree).norm() > 0.0) == (reach > 3.0));
}

}  // namespace
}  // namespace tandem::consensus::malicious_test
