// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sessions in virtual time: no socket, no clock but where a test brings its own.
#include "tandem/session.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/ragdoll.h"

namespace session_test {

using namespace tandem;
using pbd::Twist;
using pbd::Vec3;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr SessionTime kStep = 16'666'667;   // ns
constexpr SessionTime kStart = 60 * kStep;  // ns
const SharedId kCube = SharedId::from_name("cube");

static_assert(!std::is_move_constructible_v<Session>);

/// Whatever has world() and step() can be stepped; this one counts.
struct Room {
  explicit Room(double x)
      : body(own.add_body({.pose = {.position = Vec3(x, 0.0, 0.0)}, .linear_damping = 1.0})) {}
  pbd::World& world() { return own; }
  const pbd::StepReport& step(double dt) {
    ++steps;
    return solver.step(own, dt);
  }
  Vec3 position() const { return own.pose(body).position; }

  pbd::World own{testing::weightless()};
  pbd::Solver solver;
  pbd::BodyId body;
  int steps = 0;
};

struct Fixture {
  Fixture() : network({.latency = 0.05, .jitter = 0.005}, 1, kStart) {
    network.transport(1);
    network.transport(2);
  }
  consensus::Transport& transport(PeerId peer) { return network.transport(peer); }
  void advance(int steps, const std::vector<Session*>& sessions) {
    for (int i = 0; i < steps; ++i) {
      network.advance_to(network.now() + kStep);
      for (Session* const session : sessions) session->advance(network.now());
    }
  }
  consensus::VirtualNetwork network;
};

TEST_CASE("session: two peers agree on a body that one of them drags", "[session]") {
  Fixture f;
  Room near(0.0);
  Room far(0.4);
  Session one(near, f.transport(1));
  Session two({far.own, far.solver}, f.transport(2));
  CHECK(one.share("cube", near.body) == kCube);
  two.share("cube", far.body);
  const Vec3 hand(1.0, 0.2, 0.5);
  GrabId grab;
  const auto drag = [&](SessionTime now) {
    if (grab == GrabId{}) grab = one.peer().grab({.body = kCube, .anchor_w = hand});
    one.peer().move(grab, hand, now);
  };
  for (int i = 0; i < 600; ++i) {
    f.network.advance_to(f.network.now() + kStep);
    one.advance(f.network.now(), drag);
    two.advance(f.network.now());
  }
  CHECK((near.position() - far.position()).norm() < 1e-3);
  CHECK((far.position() - hand).norm() < 1e-2);
}

TEST_CASE("session: a body kicked at one of three peers flies at all of them", "[session]") {
  Fixture f;
  Room rooms[3] = {Room(0.0), Room(0.0), Room(0.0)};
  std::vector<std::unique_ptr<Session>> sessions;
  for (int i = 0; i < 3; ++i) {
    sessions.push_back(
        std::make_unique<Session>(rooms[i], f.transport(static_cast<std::uint64_t>(i + 1))));
    sessions.back()->share("cube", rooms[i].body);
  }
  const auto step = [&](int count) {
    for (int i = 0; i < count; ++i) {
      f.network.advance_to(f.network.now() + kStep);
      for (const auto& session : sessions) session->advance(f.network.now());
    }
  };
  step(120);
  sessions[2]->act({.body = kCube, .twist = Twist{{1.0, 0.0, 0.0}, Vec3::Zero()}});
  step(30);
  for (const Room& room : rooms) {
    // Half a second of damping.
    CHECK(room.own.twist(room.body).linear.x() == Approx(0.607).margin(0.02));
    CHECK((room.position() - rooms[2].position()).norm() < 0.02);
  }
}

TEST_CASE("session: the same bits as its parts put together by hand", "[session][determinism]") {
  const auto by_sessions = [] {
    Fixture f;
    Room near(0.0);
    Room far(0.4);
    Session one(near, f.transport(1));
    Session two(far, f.transport(2));
    one.share("cube", near.body);
    two.share("cube", far.body);
    f.advance(1, {&one, &two});  // begins
    f.advance(120, {&one, &two});
    return std::pair(near.own.hash(), far.own.hash());
  };
  const auto by_hand = [] {
    Fixture f;
    Room rooms[2] = {Room(0.0), Room(0.4)};
    consensus::Peer peers[2] = {{rooms[0].own, f.transport(1)}, {rooms[1].own, f.transport(2)}};
    for (int k = 0; k < 2; ++k) peers[k].share({.id = kCube, .body = rooms[k].body});
    f.network.advance_to(kStart + kStep);
    for (SessionTime now = kStart + kStep; now < kStart + 121 * kStep; now += kStep) {
      f.network.advance_to(now + kStep);
      for (int k = 0; k < 2; ++k) {
        peers[k].before_step(now);
        rooms[k].solver.step(rooms[k].own, net::seconds(kStep));
        peers[k].after_step(now + kStep);
      }
    }
    return std::pair(rooms[0].own.hash(), rooms[1].own.hash());
  };
  CHECK(by_sessions() == by_hand());
}

TEST_CASE("session: an event comes before one step, once", "[session]") {
  Fixture f;
  Room near(0.0);
  Room far(0.4);
  Session one(near, f.transport(1));
  Session two(far, f.transport(2));
  std::vector<SessionTime> came;
  SessionTime sent = 0;
  for (int i = 0; i < 60; ++i) {
    f.network.advance_to(f.network.now() + kStep);
    one.advance(f.network.now(), [&](SessionTime now) {
      if (std::exchange(sent, now) == 0) CHECK(one.events().send("round over", {}) == 1);
    });
    two.advance(f.network.now(), [&](SessionTime now) {
      for (const consensus::Event& event : two.events().received()) {
        CHECK(event.from == 1);
        CHECK(event.topic == "round over");
        came.push_back(now - event.stamp);
      }
    });
  }
  REQUIRE(came.size() == 1);
  // The way takes 45 to 55 ms, and it is read at the next step.
  CHECK(came.front() >= 45'000'000);
  CHECK(came.front() <= 55'000'000 + 2 * kStep);
}

TEST_CASE("session: steps are those of the clock", "[session]") {
  Fixture f;
  Room room(0.0);
  Session session(room, f.transport(1));
  session.share("cube", room.body);
  CHECK(session.advance(kStart + 3).steps == 0);  // the first call begins
  CHECK(session.advance(kStart + kStep - 1).steps == 0);
  CHECK(session.advance(kStart + kStep).steps == 1);
  const Progress three = session.advance(kStart + 4 * kStep + 5);
  CHECK(three.steps == 3);
  CHECK(three.lag == 5);
  CHECK(room.steps == 4);
  const Progress after_a_break = session.advance(kStart + 1000 * kStep);
  CHECK(after_a_break.steps == 1);
  CHECK(after_a_break.skipped == 995 * kStep);
  // No time at all: nothing is stepped, and it says so.
  for (const SessionTime none : {SessionTime{0}, SessionTime{-5}, kStep - 1}) {
    const Progress refused = session.advance(none);
    CHECK(refused.status == pbd::StepStatus::InvalidStep);
    CHECK(refused.steps == 0);
  }
  CHECK(room.steps == 5);
}

TEST_CASE("session: forgotten pieces are said", "[session][fault]") {
  Fixture f;
  Room room(0.0);
  {
    Session session(room, f.transport(1));
    CHECK(names(refusal([&] { session.run(); }), "number of shared bodies", "0", "at least 1"));
    CHECK(names(refusal([&] { Session second(room, f.transport(2)); }), "world", "taken",
                "no other peer"));
    session.share("cube", room.body);
    const auto body = room.own.add_body({});
    const auto wall = room.own.add_body({.type = pbd::BodyType::Static});
    CHECK(names(refusal([&] { session.share("cube", body); }), "\"cube\"", kCube.to_string(),
                "shared once only"));
    CHECK(names(refusal([&] { session.share("again", room.body); }), "\"again\"", "body",
                "under one id only"));
    CHECK(names(refusal([&] { session.share("wall", wall); }), "\"wall\"", "static", "can move"));
    CHECK(names(refusal([&] { session.share("none", pbd::BodyId{}); }), "\"none\"", "body", ""));
    SessionOptions wrong;
    wrong.pace.nominal_step = 0;
    Room other(0.0);
    CHECK(names(refusal([&] { Session third(other, f.transport(2), wrong); }), "nominal_step", "0",
                "> 0"));
    CHECK(other.own.target_source() == nullptr);  // nothing of it is left

    f.advance(2, {&session});
    CHECK_FALSE(session.advance(f.network.now()).stepped_elsewhere);
    room.step(net::seconds(kStep));
    CHECK(session.advance(f.network.now() + kStep).stepped_elsewhere);
    CHECK_FALSE(session.advance(f.network.now() + 2 * kStep).stepped_elsewhere);
  }
  CHECK(room.own.target_source() == nullptr);
  Session next(room, f.transport(1));  // the world is free again
}

TEST_CASE("session: a ragdoll is shared by one call, as a whole or not at all", "[session]") {
  Fixture f;
  Scene near, far;
  const Ragdoll here(near, {}), there(far, {.pose = {.position = Vec3(0.05, 0.0, 0.0)}});
  Session one(near, f.transport(1)), two(far, f.transport(2));
  two.share("victim/7", there.bodies()[0]);
  CHECK(names(refusal([&] { two.share("victim", there.bodies()); }), "\"victim/0\"", "body", ""));
  two.unshare(SharedId::from_name("victim/7"));
  one.share("victim", here.bodies());
  two.share("victim", there.bodies());  // nothing of the first try is left
  CHECK(names(refusal([&] { two.share("", there.bodies()); }), "name", "empty", ""));
  for (int i = 0; i < 240; ++i) {
    f.network.advance_to(f.network.now() + kStep);
    one.advance(f.network.now());
    two.advance(f.network.now());
  }
  for (std::size_t i = 0; i < Ragdoll::kParts; ++i) {
    CHECK((near.pose(here.bodies()[i]).position - far.pose(there.bodies()[i]).position).norm() <
          2e-3);
  }
}

TEST_CASE("session: a leaving member lets go at once", "[session]") {
  Fixture f;
  Room near(0.0);
  Room far(0.0);
  Session one(near, f.transport(1));
  one.share("cube", near.body);
  {
    Session two(far, f.transport(2));
    two.share("cube", far.body);
    two.peer().grab({.body = kCube, .anchor_w = Vec3(0.5, 0.0, 0.0)});
    f.advance(30, {&one, &two});
    CHECK(one.peer().held(kCube));
  }
  f.advance(6, {&one});  // 0.1 s: twice the way, a tenth of the time after which silence counts
  CHECK_FALSE(one.peer().held(kCube));
}

TEST_CASE("session: runs by any clock until it is stopped", "[session]") {
  Fixture f;
  Room room(0.0);
  SessionTime time = kStart;
  Session session(room, f.transport(1), {.clock = [&] { return time += kStep / 2; }});
  session.share("cube", room.body);
  int called = 0;
  const auto five = [&](SessionTime now) {
    CHECK(now % kStep == 0);
    if (++called == 6) session.stop();
  };
  session.run(five);
  CHECK(called == 6);
  CHECK(room.steps == 5);  // stopped before the sixth
  called = 0;
  session.run(five);  // and on
  CHECK(room.steps == 10);
  session.stop();
  CHECK(session.advance(time += 4 * kStep).steps > 0);  // nothing runs
  // A stop before the next run begins ends that run alone.
  const int steps = room.steps;
  called = 0;
  session.run(five);
  CHECK(room.steps == steps);
  session.run(five);
  CHECK(called == 6);
}

TEST_CASE("session: an exception of a call before a step passes, and the session goes on",
          "[session]") {
  Fixture f;
  Room room(0.0);
  Session session(room, f.transport(1));
  session.share("cube", room.body);
  f.advance(1, {&session});
  CHECK_THROWS_AS(session.advance(f.network.now() + kStep,
                                  [](SessionTime) { throw std::runtime_error("mine"); }),
                  std::runtime_error);
  CHECK(room.steps == 0);
  // Steps kept back come with the next call, and were not stepped elsewhere.
  CHECK(session.advance(f.network.now() + 3 * kStep).steps == 3);
  int calls = 0;
  CHECK_THROWS(session.advance(f.network.now() + 7 * kStep, [&](SessionTime) {
    if (++calls == 3) throw std::runtime_error("mine");
  }));
  CHECK(room.steps == 5);
  const Progress rest = session.advance(f.network.now() + 7 * kStep);
  CHECK_FALSE(rest.stepped_elsewhere);
  CHECK(rest.steps == 2);
}

/// Options of an application's own transport.
struct MyTransport final : consensus::Transport {
  explicit MyTransport(const struct MyOptions& options);
  ~MyTransport() override { *gone = true; }
  PeerId self() const override { return 1; }
  bool post(PeerId, std::span<const std::byte>, consensus::Delivery) override { return true; }
  void drain(std::vector<consensus::Packet>&) override {}
  void drop(PeerId, const std::string&) override {}
  std::vector<consensus::PeerStatus> peers() const override { return {}; }
  SessionTime session_now() const { return 77 * kStep; }
  bool* gone;
};
struct MyOptions {
  using Transport = MyTransport;
  bool* gone = nullptr;
  net::Clock clock = net::Clock::None;
};
MyTransport::MyTransport(const MyOptions& options) : gone(options.gone) {}

TEST_CASE("session: owns a transport made from options, and goes by its clock", "[session]") {
  bool gone = false;
  Room room(0.0);
  {
    Session session(room, MyOptions{&gone});
    CHECK(session.transport().self() == 1);
    CHECK(session.now() == 77 * kStep);
    CHECK_FALSE(gone);
  }
  CHECK(gone);
}

}  // namespace session_test
