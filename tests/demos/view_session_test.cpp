// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <memory>

#include "runs.h"
#include "scenes/cubes.h"
#include "support/catch.h"
#include "view/frame_encoder.h"
#include "view/live_session.h"

namespace tandem::demos::view::view_session_test {
namespace {

using pbd::Vec3;

/// A cube on the ground, and nobody who acts.
class OneCube final : public Scenario {
 public:
  OneCube() : Scenario("one cube", 0) {}
  Scene build(const SceneOptions& options) const override {
    SceneBuilder builder;
    builder.box("cube", Vec3::Constant(0.1), 0.3, Vec3(0.0, 0.0, 0.05));
    return builder.build(options, 0.5);
  }
  std::unique_ptr<User> make_user(std::size_t user, Controls&, const UserOptions&) const override {
    require_user(user);
    return nullptr;
  }
};

constexpr double kFrame = 1.0 / 60.0;
constexpr PageId kPage = 5;

DemoOptions options_of(int profile) {
  DemoOptions options = quiet(profile, 10.0);
  options.view = 0;
  return options;
}

Vec3 position(const LiveSession& session, std::size_t pane, std::size_t body = 0) {
  return session.scene(pane).pose(body).position;
}

void grab(LiveSession& session, std::size_t pane, std::size_t body = 0) {
  REQUIRE_FALSE(session.apply(kPage, Grab{1, pane, body, position(session, pane, body)}));
}

void pull_to(LiveSession& session, const Vec3& point) {
  REQUIRE_FALSE(session.apply(kPage, Move{1, point}));
}

std::uint64_t hash(const LiveSession& session) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < session.panes(); ++i) {
    sum = sum * 31 + session.scene(i).world->hash();
  }
  return sum;
}

TEST_CASE("live session: untouched, it is the run in virtual time, however it is cut",
          "[demos][view][golden]") {
  const CubesScenario scenario(
      CubesOptions{.stacks = 2, .height = 3, .plate = Vec3(0.8, 0.8, 0.04)});
  DemoOptions options = quiet(3, 2.0);
  options.rates = {60.0, 72.0};
  const RunResult whole = run_virtual(scenario, options);
  LiveSession session(scenario, options);
  for (int i = 1; i <= 140; ++i) session.advance_to(i * 2.0 / 140.0);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(session.scene(i).world->hash() == whole.peers[i].hash);
  }
  session.restart();
  CHECK(session.time() == 0.0);
  session.advance_to(2.0);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(session.scene(i).world->hash() == whole.peers[i].hash);
  }
}

TEST_CASE("live session: a body pulled in one pane follows in the other, then both agree",
          "[demos][view][analytic]") {
  for (const int profile : {0, 3, 5}) {
    INFO("profile " << profile);
    const OneCube scenario;
    LiveSession session(scenario, options_of(profile));
    session.advance_to(1.5);
    const Vec3 start = position(session, 1);
    const double told = session.time();
    grab(session, 0);
    pull_to(session, Vec3(0.2, 0.0, 0.3));
    double moved_here = -1.0, moved_there = -1.0;
    while (session.time() < told + 2.0) {
      session.advance_to(session.time() + 1e-3);
      const auto moved = [&](std::size_t pane) {
        return (position(session, pane) - start).norm() > 0.01;
      };
      if (moved_here < 0.0 && moved(0)) moved_here = session.time() - told;
      if (moved_there < 0.0 && moved(1)) moved_there = session.time() - told;
    }
    CHECK(moved_here > 0.0);
    CHECK(moved_here < 0.1);
    const double latency = profile == 0 ? 0.0 : consensus::network_profile(profile).latency;
    CHECK(moved_there > latency);
    CHECK(moved_there < latency + 0.1);
    // Both hold it up, by a spring that sags by 1 cm.
    for (const std::size_t pane : {0, 1}) {
      CHECK(position(session, pane).z() == Approx(0.29).margin(0.01));
    }
    REQUIRE_FALSE(session.apply(kPage, Release{1}));
    session.advance_to(session.time() + 4.0);
    CHECK(position(session, 0).z() == Approx(0.05).margin(2e-3));
    CHECK((position(session, 0) - position(session, 1)).norm() < 2e-3);
  }
}

TEST_CASE("live session: a page that is gone holds nothing", "[demos][view][unit]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(1));
  session.advance_to(0.5);
  grab(session, 1);
  pull_to(session, Vec3(0.0, 0.0, 0.5));
  session.advance_to(2.0);
  CHECK(session.grips(1) == 1);
  session.leave(kPage + 1);
  session.advance_to(2.1);
  CHECK(session.grips(1) == 1);
  CHECK(position(session, 0).z() > 0.4);
  session.leave(kPage);
  session.advance_to(5.0);
  CHECK(session.grips(1) == 0);
  for (const std::size_t pane : {0, 1}) CHECK(position(session, pane).z() < 0.06);
  // The body that it moves now has no owner.
  pull_to(session, Vec3(0.0, 0.0, 1.0));
  session.advance_to(6.0);
  CHECK(position(session, 1).z() < 0.06);
}

TEST_CASE("live session: another link, scheme, predictor or influence moves nothing",
          "[demos][view][golden]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(3));
  session.advance_to(0.5);
  grab(session, 0);
  pull_to(session, Vec3(0.1, 0.0, 0.4));
  session.advance_to(1.0);
  const auto change = [&](const Command& command) {
    const std::uint64_t before = hash(session);
    REQUIRE_FALSE(session.apply(kPage, command));
    CHECK(hash(session) == before);
    CHECK(session.grips(0) == 1);
    session.advance_to(session.time() + 0.25);
    for (const std::size_t pane : {0, 1}) CHECK(position(session, pane).allFinite());
  };
  change(SetProfile{5});
  CHECK(session.settings().profile == 5);
  change(SetInfluence{0.2});
  CHECK(session.settings().influence == 0.2);
  for (int i = 0; i <= static_cast<int>(Scheme::SingleOwner); ++i) {
    INFO(to_string(static_cast<Scheme>(i)));
    change(SetScheme{static_cast<Scheme>(i)});
    CHECK(session.settings().scheme == static_cast<Scheme>(i));
  }
  change(SetScheme{Scheme::OnePass});
  for (int i = 0; i <= static_cast<int>(consensus::PredictorKind::Replay); ++i) {
    const auto kind = static_cast<consensus::PredictorKind>(i);
    INFO(to_string(kind));
    change(SetPredictor{kind});
    CHECK(session.settings().predictor == kind);
  }
  // The hand has held it all the time, and does at the other peer.
  session.advance_to(session.time() + 2.0);
  for (const std::size_t pane : {0, 1}) {
    CHECK(position(session, pane).z() == Approx(0.39).margin(0.01));
  }
  session.leave(kPage);
  session.advance_to(session.time() + 4.0);
  for (const std::size_t pane : {0, 1}) CHECK(position(session, pane).z() < 0.06);
}

TEST_CASE("live session: paused, no time passes but by steps", "[demos][view][unit]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(2));
  session.pass(0.5);
  CHECK(session.time() == Approx(0.5));
  REQUIRE_FALSE(session.apply(kPage, SetSpeed{0.1}));
  session.pass(0.5);
  CHECK(session.time() == Approx(0.55));
  REQUIRE_FALSE(session.apply(kPage, SetPaused{true}));
  const std::uint64_t before = hash(session);
  // Pages get nothing new while it is paused, but what says now and then that it is still there.
  FrameEncoder encoder(session.layout());
  Frame frame;
  session.show(frame, true);
  CHECK(encoder.take(frame, false));
  grab(session, 0);
  pull_to(session, Vec3(0.0, 0.0, 1.0));
  session.pass(1.0);
  CHECK(session.time() == Approx(0.55));
  CHECK(hash(session) == before);
  session.show(frame, true);
  CHECK_FALSE(encoder.take(frame, false));
  REQUIRE_FALSE(session.apply(kPage, Step{}));
  CHECK(session.time() == Approx(0.55 + kFrame));
  REQUIRE_FALSE(session.apply(kPage, SetPaused{false}));
  REQUIRE_FALSE(session.apply(kPage, SetSpeed{2.0}));
  session.pass(0.5);
  CHECK(session.time() == Approx(1.55 + kFrame));
  CHECK(position(session, 0).z() > 0.1);
}

TEST_CASE("live session: a frame shows springs, contacts, beliefs and divergence",
          "[demos][view][unit]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(3));
  session.advance_to(2.0);
  Frame frame;
  session.show(frame, true);
  REQUIRE(frame.panes.size() == 2);
  CHECK(frame.panes[0].poses[0].position == position(session, 0));
  // It lies on four corners at the height of the ground.
  REQUIRE(frame.panes[1].contacts.size() == 4);
  for (const ContactMark& contact : frame.panes[1].contacts) {
    CHECK(std::abs(contact.point.z()) < 2e-3);
    CHECK(std::abs(contact.normal.z()) == Approx(1.0));
    CHECK(contact.depth < 5e-3);
  }
  CHECK(frame.panes[0].springs.empty());
  CHECK(frame.panes[0].latency_ms == Approx(28.5 + 8.0).margin(12.0));
  CHECK(frame.panes[0].divergence_max_mm < 1.0);

  grab(session, 1);
  pull_to(session, Vec3(0.3, 0.0, 0.3));
  session.advance_to(2.15);
  session.show(frame, true);
  for (const std::size_t pane : {0, 1}) {
    INFO("pane " << pane);
    REQUIRE(frame.panes[pane].springs.size() == 1);
    const SpringMark& spring = frame.panes[pane].springs[0];
    CHECK(spring.pane == 1);
    CHECK(spring.own == (pane == 1));
    CHECK((spring.attachment - frame.panes[pane].poses[0].position).norm() < 0.01);
  }
  // The follower believes the leader to have it somewhere, and the leader asks for much.
  REQUIRE(frame.panes[0].targets.size() == 1);
  CHECK(frame.panes[0].targets[0].pane == 1);
  CHECK(frame.panes[1].influence[0] > 100);
  CHECK(frame.panes[0].divergence_max_mm == Approx(frame.panes[1].divergence_max_mm));
  // Two panes are as far from their mean, half of what is between them in the picture.
  const double apart = (frame.panes[0].poses[0].position - frame.panes[1].poses[0].position).norm();
  CHECK(frame.panes[0].divergence_max_mm == Approx(500.0 * apart));
  session.show(frame, false);
  CHECK(frame.panes[0].springs.size() == 1);
  CHECK(frame.panes[0].contacts.empty());
}

/// A ball in free flight, high enough not to land.
class FreeFall final : public Scenario {
 public:
  FreeFall() : Scenario("free fall", 0) {}
  Scene build(const SceneOptions& options) const override {
    SceneBuilder builder;
    builder.box("ball", Vec3::Constant(0.1), 0.3, Vec3(0.0, 0.0, 15.0));
    return builder.build(options, 0.5);
  }
  std::unique_ptr<User> make_user(std::size_t user, Controls&, const UserOptions&) const override {
    require_user(user);
    return nullptr;
  }
};

TEST_CASE("live session: a frame shows all peers at its own time, between their steps",
          "[demos][view][analytic]") {
  // Without agreement, each falls for itself, in steps of its own length. Substeps h of first order
  // are off the parabola by g t h / 2: 9 mm and 35 mm of 1.06 s at four of them, and as much apart.
  const FreeFall scenario;
  DemoOptions options = options_of(0);
  options.scheme = Scheme::None;
  options.rates = {60.0, 37.0};
  LiveSession session(scenario, options);
  Frame frame;
  double stepwise = 0.0;
  for (int i = 1; i <= 94; ++i) {
    const double t = i * 0.0113;
    session.advance_to(t);
    session.show(frame, false);
    INFO(t);
    for (const PaneFrame& pane : frame.panes) {
      CHECK(15.0 - pane.poses[0].position.z() == Approx(0.5 * 9.81 * t * t).margin(0.04));
    }
    stepwise = std::max(stepwise, std::abs(position(session, 0).z() - position(session, 1).z()));
  }
  // The worlds themselves are apart by what is fallen in a step: 0.28 m in 1/37 s at 10.4 m/s.
  CHECK(stepwise > 0.15);
}

TEST_CASE("live session: the run beside has the same users with the same hands",
          "[demos][view][golden]") {
  const CubesScenario scenario(
      CubesOptions{.stacks = 2, .height = 3, .plate = Vec3(0.8, 0.8, 0.04)});
  DemoOptions options = quiet(3, 2.0);
  LiveSession session(scenario, options);
  session.advance_to(0.5);
  CHECK(session.panes() == 2);
  CHECK(session.apply(kPage, Grab{1, 2, 0, Vec3::Zero()}) ==
        "pane must be one that is shown, is 2");
  // The same scheme: whatever the users do, both runs are the same to the bit.
  REQUIRE_FALSE(session.apply(kPage, SetBeside{options.scheme}));
  CHECK(session.time() == 0.0);
  CHECK(session.panes() == 4);
  session.advance_to(0.6);
  REQUIRE_FALSE(session.apply(kPage, Grab{1, 0, 0, position(session, 0) + Vec3(0.3, 0.1, 0.0)}));
  REQUIRE_FALSE(session.apply(kPage, Grab{2, 3, 1, position(session, 3, 1)}));
  for (int i = 1; i <= 30; ++i) {
    REQUIRE_FALSE(session.apply(kPage, Move{1, Vec3(0.3, 0.1, 0.01 * i)}));
    REQUIRE_FALSE(session.apply(kPage, Move{2, Vec3(-0.2, 0.02 * i, 0.4)}));
    session.advance_to(0.6 + i / 30.0);
    if (i == 20) REQUIRE_FALSE(session.apply(kPage, SetProfile{5}));
    for (const std::size_t peer : {0, 1}) {
      CHECK(session.scene(peer).world->hash() == session.scene(peer + 2).world->hash());
      CHECK(session.grips(peer) == session.grips(peer + 2));
    }
  }
  CHECK(session.grips(0) == 1);
  session.leave(kPage);
  session.advance_to(2.0);
  for (const std::size_t pane : {0, 1, 2, 3}) CHECK(session.grips(pane) == 0);
  Frame frame;
  session.show(frame, true);
  REQUIRE(frame.panes.size() == 4);
  CHECK(session.outcomes().size() == 4);
  // Without it the run goes on as it was.
  const std::uint64_t before = session.scene(0).world->hash();
  REQUIRE_FALSE(session.apply(kPage, SetBeside{}));
  CHECK(session.panes() == 2);
  CHECK(session.scene(0).world->hash() == before);
}

TEST_CASE(
    "live session: without agreement beside it, the same push drives copies apart there alone",
    "[demos][view][analytic]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(5));
  REQUIRE_FALSE(session.apply(kPage, SetBeside{Scheme::None}));
  session.advance_to(1.0);
  // A quick pull over the ground, which a peer that hears of it later does in another way.
  grab(session, 2);
  pull_to(session, Vec3(0.6, 0.0, 0.3));
  session.advance_to(1.4);
  session.leave(kPage);
  session.advance_to(5.0);
  const auto apart = [&](std::size_t a, std::size_t b) {
    return (position(session, a) - position(session, b)).norm();
  };
  CHECK(position(session, 0).x() > 0.1);
  CHECK(position(session, 2).x() > 0.1);
  CHECK(apart(0, 1) < 2e-3);
  CHECK(apart(2, 3) > 5.0 * apart(0, 1));
}

TEST_CASE("live session: a hand that leaps throws nothing away", "[demos][view][analytic]") {
  const OneCube scenario;
  LiveSession session(scenario, options_of(0));
  session.advance_to(1.0);
  grab(session, 0);
  // At once, to where a page may be asked for at most.
  pull_to(session, Vec3(0.0, 0.0, 1.0));
  double highest = 0.0;
  while (session.time() < 4.0) {
    session.advance_to(session.time() + 0.01);
    highest = std::max(highest, position(session, 0).z());
    if (session.time() < 1.3) CHECK(position(session, 0).z() < 0.05 + PointerHand::kFastest * 0.3);
  }
  CHECK(position(session, 0).z() == Approx(0.99).margin(0.01));
  // It comes to rest from kFastest by three times its weight, and gravity helps: v^2 / (2 * 4 g).
  CHECK(highest < 1.0 + PointerHand::kFastest * PointerHand::kFastest / (8.0 * 9.81) + 0.02);
}

}  // namespace
}  // namespace tandem::demos::view::view_session_test
