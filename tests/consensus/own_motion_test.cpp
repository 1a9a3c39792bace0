// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The own motion that predictors are told of: what the body did, at any time of the last second.
#include <functional>
#include <utility>
#include <vector>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"
#include "support/oracles.h"

namespace tandem::consensus::own_motion_test {
namespace {

using namespace testing;
using tandem::testing::angle_between;

constexpr double kFrame = 1.0 / 60.0;

/// Shows the local motion whenever a remote state is used.
struct Look final : PeerObserver {
  std::function<void(const MotionHistory&)> at;
  void on_estimate(const EstimateEvent& event) override { at(event.own); }
};

/// A ball in flight that spins, and another peer that says something of it in each step.
struct Flight {
  explicit Flight(double second = kFrame) : dt(ns(second)) {
    site.share(ball(Vec3(1.0, 2.0, 3.0), Vec3(4.0, -1.0, 6.0)));
    site.world.set_twist(site.body, {Vec3(4.0, -1.0, 6.0), Vec3(0.0, 0.0, 3.0)});
    site.peer->set_observer(&look);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      StateUpdate update;
      update.id = kBody;
      update.pose = site.pose();
      update.twist = site.twist();
      update.influence = 0.05f;
      update.stamp = now;
      stub.deliver(2, update);
      track.push_back({now, site.pose(), site.twist()});
      looked = false;
      site.peer->before_step(now);
      REQUIRE(looked);
      site.solver.step(site.world, 1e-9 * static_cast<double>(dt));
      now += dt;
      site.peer->after_step(now);
    }
  }

  StubTransport stub{1};
  Site site{stub, PeerOptions{.predictor = PredictorKind::None, .authority_ramp = 0.0}, {}};
  Look look;
  SessionTime dt;
  SessionTime now = kStart;
  std::vector<MotionSample> track;  ///< at the beginning of each step
  bool looked = false;
};

/// Hermite's cubic through two states with their velocities.
Vec3 between(const MotionSample& a, const MotionSample& b, double f) {
  const double dt = 1e-9 * static_cast<double>(b.time - a.time);
  const double g = 1.0 - f;
  return (1.0 + 2.0 * f) * g * g * a.pose.position + f * g * g * dt * a.twist.linear +
         f * f * (3.0 - 2.0 * f) * b.pose.position - f * f * g * dt * b.twist.linear;
}

TEST_CASE("own motion: it gives past states at the times of steps and the present one now",
          "[consensus][unit]") {
  Flight flight;
  flight.look.at = [&](const MotionHistory& own) {
    flight.looked = true;
    CHECK(own.newest().time == flight.now);
    CHECK(own.newest().pose.position == flight.site.x());
    CHECK(own.newest().twist.angular == flight.site.twist().angular);
    for (const MotionSample& then : flight.track) {
      if (then.time < flight.now - ns(0.9)) continue;
      CHECK(own.at_time(then.time).time == then.time);
      CHECK(own.at_time(then.time).pose.position == then.pose.position);
      CHECK(own.at_time(then.time).twist.linear == then.twist.linear);
    }
  };
  flight.run(150);  // longer than anything is remembered
}

TEST_CASE("own motion: between two steps it is the cubic that has their velocities",
          "[consensus][analytic]") {
  Flight flight;
  flight.look.at = [&](const MotionHistory& own) {
    flight.looked = true;
    if (flight.track.size() < 20) return;
    const MotionSample& a = flight.track[flight.track.size() - 12];
    const MotionSample& b = flight.track[flight.track.size() - 11];
    for (const double f : {0.1, 0.5, 0.9}) {
      const SessionTime time = a.time + std::llround(f * static_cast<double>(b.time - a.time));
      const double part = static_cast<double>(time - a.time) / static_cast<double>(b.time - a.time);
      const MotionSample then = own.at_time(time);
      CHECK((then.pose.position - between(a, b, part)).norm() < 1e-12);
      CHECK((then.twist.linear - (1.0 - part) * a.twist.linear - part * b.twist.linear).norm() <
            1e-12);
      // A steady spin goes on evenly.
      const double turned = angle_between(a.pose.orientation, then.pose.orientation);
      CHECK(turned == Approx(part * 3.0 * kFrame).epsilon(1e-6));
    }
  };
  flight.run(40);
}

TEST_CASE("own motion: times outside the record are clamped to it", "[consensus][unit]") {
  Flight flight;
  flight.look.at = [&](const MotionHistory& own) {
    flight.looked = true;
    CHECK(own.at_time(flight.now + ns(1.0)).pose.position == flight.site.x());
    const Vec3 first = own.at_time(1).pose.position;
    const double known = 1e-9 * static_cast<double>(flight.now - kStart);
    if (known < 0.9) {
      CHECK(first == flight.track.front().pose.position);
    } else if (known > 1.5) {
      // About a second is remembered: of the flight's beginning nothing is left.
      CHECK((first - flight.track.front().pose.position).norm() > 0.1);
    }
  };
  flight.run(150);
}

TEST_CASE("own motion: of a body that was added nothing is known from before",
          "[consensus][unit]") {
  Flight flight;
  flight.look.at = [&](const MotionHistory&) { flight.looked = true; };
  flight.run(30);
  const SharedId late = SharedId::from_name("late");
  const pbd::BodyId body = flight.site.world.add_body(ball(Vec3(7.0, 0.0, 0.0)));
  flight.site.peer->share({.id = late, .body = body});
  const SessionTime added = flight.now;
  StateUpdate update;
  update.id = late;
  update.influence = 0.05f;
  update.pose.position = Vec3(7.0, 0.0, 0.0);
  update.stamp = added - ns(0.2);
  flight.stub.deliver(2, update);
  flight.look.at = [&](const MotionHistory& own) {
    flight.looked = true;
    if (std::abs(own.newest().pose.position.x() - 7.0) > 0.1) return;
    CHECK(own.at_time(added - ns(0.2)).pose.position.x() == 7.0);
  };
  flight.run(2);
}

}  // namespace
}  // namespace tandem::consensus::own_motion_test
