// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/peer.h"

#include <cmath>
#include <limits>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::consensus::peer_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kFrame = 1.0 / 60.0;

TEST_CASE("peer: options out of their rules are refused by name", "[consensus]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const PeerOptions& options, const char* field, const char* value) {
    const std::string message = refusal([&] { options.validate(); });
    INFO(field << " = " << value << ": " << message);
    CHECK(names(message, field, value, "must be"));
  };
  refused({.update_hz = 0.0}, "update_hz", "is 0");
  refused({.update_hz = nan}, "update_hz", "nan");
  refused({.update_hz = 1e5}, "update_hz", "100000");
  refused({.authority_ramp = -1.0}, "authority_ramp", "is -1");
  refused({.spring_timeout = 0.0}, "spring_timeout", "is 0");
  refused({.max_anchor_extrapolation = -0.1}, "max_anchor_extrapolation", "-0.1");
  CHECK(refusal([] { PeerOptions{.influence = {.baseline = 2.0}}.validate(); }).find("baseline") !=
        std::string::npos);
  CHECK_NOTHROW(PeerOptions{}.validate());

  StubTransport transport(1);
  pbd::World world;
  CHECK_THROWS_AS(Peer(world, transport, {.update_hz = -1.0}), std::invalid_argument);
}

TEST_CASE("peer: a body is shared once, under a valid id, and must exist", "[consensus]") {
  StubTransport transport(1);
  Site site(transport, {}, {});
  site.share(ball(Vec3::Zero()));
  const pbd::BodyId other = site.world.add_body(ball(Vec3::UnitX()));
  CHECK(names(refusal([&] { site.peer->share({.id = kBody, .body = other}); }), "id",
              kBody.to_string(), "once"));
  CHECK(refusal([&] { site.peer->share({.id = {}, .body = other}); }).find("not zero") !=
        std::string::npos);
  CHECK(refusal([&] {
          site.peer->share({.id = {1, 2}, .body = {99, 0}});
        }).find("body") != std::string::npos);
  CHECK_NOTHROW(site.peer->share({.id = {1, 2}, .body = other}));
}

TEST_CASE("peer: states go out at a fixed rate for any steps", "[consensus]") {
  const double hz = GENERATE(60.0, 72.0, 240.0, 31.0);
  const double update_hz = GENERATE(10.0, 60.0);
  CAPTURE(hz, update_hz);
  StubTransport transport(1);
  transport.known.push_back({.id = 2, .connected = true});
  transport.known.push_back({.id = 3, .connected = false, .reason = "gone"});
  Site site(transport, {.update_hz = update_hz}, kWeightless);
  site.share(ball(Vec3::Zero()));
  const int steps = static_cast<int>(10.0 * hz);
  for (int k = 0; k < steps; ++k) {
    const SessionTime now = kStart + ns(k / hz);
    site.peer->before_step(now);
    site.solver.step(site.world, 1.0 / hz);
    site.peer->after_step(kStart + ns((k + 1) / hz));
  }
  // To the connected peer only; no more often than there are steps. Two may go out at the start.
  const double wanted = 10.0 * std::min(hz, update_hz);
  CHECK(std::abs(static_cast<double>(transport.posted.size()) - wanted) <= 2.0);
  std::uint64_t bytes = 0;
  for (const auto& packet : transport.posted) bytes += packet.size();
  CHECK(site.peer->stats().bytes_sent == bytes);
}

TEST_CASE("peer: a state has the solver's result, with pose and stamp", "[consensus]") {
  StubTransport transport(1);
  transport.known.push_back({.id = 2, .connected = true});
  Site site(transport, {.authority_ramp = 0.5}, {});
  site.share(cube({0.0, 0.0, kHalf.z()}));
  put_on_plane(site);
  DecodedPacket packet;
  const auto run_step = [&](int k) {
    site.peer->before_step(kStart + ns(k * kFrame));
    site.solver.step(site.world, kFrame);
    site.peer->after_step(kStart + ns((k + 1) * kFrame));
    REQUIRE(decode(transport.posted.back(), packet).ok());
    REQUIRE(packet.states.size() == 1);
    return packet.states[0];
  };
  StateUpdate state;
  for (int k = 0; k < 60; ++k) {
    state = run_step(k);
    // Heard more and more over the ramp that begins with the first step's end.
    const double ramp = std::min(1.0, k * kFrame / 0.5);
    CHECK(state.influence == Approx(0.08 * ramp).margin(1e-7));
  }
  CHECK(state.id == kBody);
  CHECK(state.stamp == kStart + ns(60 * kFrame));
  CHECK(state.pose.position == site.x());
  CHECK((state.twist.linear - site.v()).norm() < 1e-7);
  CHECK(state.flags.in_contact);
  CHECK_FALSE(state.flags.held);
  CHECK_FALSE(state.flags.owner_driven);

  const GrabId grab = site.peer->grab({.body = kBody, .anchor_w = Vec3(0.0, 0.0, 0.2)});
  CHECK(run_step(60).flags.held);
  site.peer->release(grab);
  CHECK_FALSE(run_step(61).flags.held);
  site.peer->set_owner(kBody, PeerId{1});
  state = run_step(62);
  CHECK(state.influence == 1.0f);
  CHECK_FALSE(state.flags.owner_driven);  // its owner simulates it as all do
  site.peer->set_owner(kBody, PeerId{2});
  state = run_step(63);
  CHECK(state.influence == 0.0f);
  CHECK_FALSE(state.flags.owner_driven);
}

TEST_CASE("peer: an observer is told the applied states and their ages", "[consensus]") {
  struct Observer final : PeerObserver {
    int calls = 0;
    double age = 0.0;
    Vec3 position = Vec3::Zero();
    void on_estimate(const EstimateEvent& event) override {
      CHECK(event.from == 2);
      CHECK(event.update.id == kBody);
      ++calls;
      age = event.age;
      position = event.position;
    }
  } observer;
  StubTransport transport(1);
  Site site(transport, {.predictor = PredictorKind::Euler}, kWeightless);
  site.share(ball(Vec3::Zero()));
  site.peer->set_observer(&observer);
  StateUpdate update;
  update.id = kBody;
  update.pose.position = Vec3(0.1, 0.0, 0.0);
  update.twist.linear = Vec3(1.0, 0.0, 0.0);
  update.influence = 0.1f;
  update.stamp = kStart - ns(0.05);
  transport.deliver(2, update);
  site.peer->before_step(kStart);
  CHECK(observer.calls == 1);
  CHECK(observer.age == Approx(0.05).epsilon(1e-9));
  CHECK((observer.position - Vec3(0.15, 0.0, 0.0)).norm() < 1e-8);
  // The newest update is applied again in each step until it has expired.
  site.peer->before_step(kStart + ns(0.5));
  CHECK(observer.calls == 2);
  site.peer->before_step(kStart + ns(1.0));
  CHECK(observer.calls == 2);
  CHECK(site.peer->stats().bodies_aggregated == 2);
}

}  // namespace
}  // namespace tandem::consensus::peer_test
