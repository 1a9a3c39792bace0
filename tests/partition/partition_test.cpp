// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "benchmarks/partition/partition.h"

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "consensus/peer_fixture.h"
#include "consensus/random.h"
#include "consensus/stub_transport.h"
#include "support/bodies.h"
#include "support/catch.h"

namespace tandem::consensus::partition_test {
namespace {

using namespace testing;
using namespace partition_bench;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kFrame = 1.0 / 60.0;  // s

SharedId id_of(int ball) { return SharedId::from_name("ball/" + std::to_string(ball)); }

/// Contacts between all balls of a world.
class BallContacts final : public pbd::ContactSource {
 public:
  std::map<int, pbd::BodyId> balls;

  void collect(const pbd::World& world, double /*dt*/, pbd::Workers& /*workers*/,
               std::vector<pbd::Manifold>& out) override {
    for (const auto& [i, a] : balls) {
      for (const auto& [j, b] : balls) {
        if (j <= i) continue;
        const Vec3 way = world.pose(b).position - world.pose(a).position;
        if (way.norm() > 2.0 * kBallRadius + 0.1) continue;
        pbd::Manifold& m = out.emplace_back();
        m.key = static_cast<std::uint64_t>(100 * i + j);
        m.body_a = a.index;
        m.body_b = b.index;
        m.normal = way.normalized();
        m.radius_a = m.radius_b = kBallRadius;
        m.count = 1;
      }
    }
  }
  void remove_body(pbd::BodyId /*body*/) override {}
  void save(pbd::ByteWriter& /*out*/) const override {}
  void load(pbd::ByteReader& /*in*/) override {}
};

/// A world in parts of balls that touch each other.
class Part final : private PartitionBodies {
 public:
  Part(Transport& transport, const std::vector<PartitionCell>& cells, const pbd::WorldDef& def,
       const PartitionOptions& options)
      : world(def), peer(world, transport, {.authority_ramp = 0.0}) {
    world.set_contact_source(&contacts);
    PartitionBodies& bodies = *this;
    partition = std::make_unique<Partition>(world, peer, bodies, transport.self(), cells, options);
  }

  void add(int ball_number, const pbd::BodyDef& def) {
    const pbd::BodyId body = world.add_body(def);
    contacts.balls[ball_number] = body;
    partition->add(id_of(ball_number), body);
  }
  bool has(int ball_number) const { return contacts.balls.count(ball_number) != 0; }
  const pbd::BodyState& state(int ball_number) const {
    return world.state(contacts.balls.at(ball_number));
  }
  void step(SessionTime from, SessionTime to) {
    peer.before_step(from);
    solver.step(world, 1e-9 * static_cast<double>(to - from));
    partition->update(to);
    peer.after_step(to);
  }

  pbd::World world;
  pbd::Solver solver;
  BallContacts contacts;
  Peer peer;
  std::unique_ptr<Partition> partition;

 private:
  pbd::BodyId appear(const SharedId& id, const Pose& pose, const Twist& twist) override {
    for (int i = 0; i < 100; ++i) {
      if (id_of(i) != id) continue;
      pbd::BodyDef def = ball(pose.position, twist.linear);
      return contacts.balls[i] = world.add_body(def);
    }
    return {};
  }
  void vanish(const SharedId& /*id*/, pbd::BodyId body) override {
    std::erase_if(contacts.balls, [&](const auto& entry) { return entry.second == body; });
    world.remove_body(body);
  }
};

/// Two peers, the border at x = 0.
struct Halves {
  explicit Halves(const LinkOptions& link = {}, const pbd::WorldDef& def = {})
      : network(link, 1, kStart) {
    std::vector<PartitionCell> cells(2);
    cells[0].peer = 1;
    cells[0].cell.max.x() = 0.0;
    cells[1].peer = 2;
    cells[1].cell.min.x() = 0.0;
    network.transport(1);
    network.transport(2);
    for (const PeerId peer : {1, 2}) {
      parts.push_back(std::make_unique<Part>(network.transport(peer), cells, def, options));
    }
  }
  void add(int ball_number, const pbd::BodyDef& def) {
    for (const auto& part : parts) part->add(ball_number, def);
  }
  void step() {
    const SessionTime from = kStart + ns(steps * kFrame);
    const SessionTime to = kStart + ns((steps + 1) * kFrame);
    network.advance_to(from);
    for (const auto& part : parts) part->step(from, to);
    ++steps;
  }
  double time() const { return steps * kFrame; }
  /// As the peer has it in whose cell it is.
  const pbd::BodyState* decided(int ball_number) const {
    for (std::size_t p = 0; p < 2; ++p) {
      if (!parts[p]->has(ball_number)) continue;
      const pbd::BodyState& state = parts[p]->state(ball_number);
      if ((state.pose.position.x() >= 0.0) == (p == 1)) return &state;
    }
    return nullptr;
  }

  PartitionOptions options{};
  VirtualNetwork network;
  std::vector<std::unique_ptr<Part>> parts;
  int steps = 0;
};

TEST_CASE("cells: each point lies in one cell, and each cell has its part of the points",
          "[consensus]") {
  const std::size_t count = GENERATE(1U, 2U, 3U, 4U, 7U, 8U);
  CAPTURE(count);
  Dice random(7);
  std::vector<Vec3> points;
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(random.uniform(-3.0, 5.0), random.uniform(0.0, 1.0),
                        random.uniform(0.0, 9.0));
  }
  const std::vector<Cell> cells = split_cells(points, count);
  REQUIRE(cells.size() == count);
  std::vector<int> inside(count, 0);
  for (const Vec3& point : points) {
    int homes = 0;
    double outside = -std::numeric_limits<double>::infinity();
    double deep = 0.0;
    for (std::size_t c = 0; c < count; ++c) {
      const double depth = depth_in(cells[c], point);
      if (depth > 0.0) {
        ++homes;
        ++inside[c];
        deep = depth;
      } else {
        outside = std::max(outside, depth);
      }
    }
    CHECK(homes == 1);
    // The nearest other cell is as far as the border.
    if (count > 1) CHECK(-outside == Approx(deep).epsilon(1e-12));
  }
  const int share = static_cast<int>(1000 / count);
  for (const int n : inside) CHECK(std::abs(n - share) <= 2);
}

TEST_CASE("cells: nonsense is refused by name", "[consensus]") {
  const std::vector<Vec3> bad = {Vec3(0.0, std::nan(""), 0.0)};
  CHECK(names(refusal([] { split_cells({}, 0); }), "split_cells", "count", "at least 1"));
  CHECK(names(refusal([&] { split_cells(bad, 2); }), "split_cells", "points", "finite"));
  CHECK(names(refusal([] { split_cells({}, 2, {false, false, false}); }), "axes", "none", "cut"));
  CHECK(names(refusal([] { PartitionOptions{.overlap = 0.0}.validate(); }), "overlap", "is 0",
              "above 0"));
  CHECK(names(refusal([] { PartitionOptions{.slack = 1.0}.validate(); }), "slack", "is 1",
              "overlap"));
  StubTransport transport(3);
  CHECK(names(refusal([&] { Part(transport, {{1, {}}, {2, {}}}, {}, {}); }), "self", "3", "cell"));
  CHECK(names(refusal([&] {
                Part(transport, {{3, {}}, {3, {}}}, {}, {});
              }),
              "cells[1]", "3", "one"));
}

TEST_CASE("partition: a ball that flies over the border changes hands and keeps its path",
          "[consensus]") {
  const double latency = GENERATE(0.0, 0.001, 0.03);
  CAPTURE(latency);
  Halves halves({.latency = latency});
  const Vec3 from(-2.0, 0.3, 1.0);
  const Vec3 speed(3.0, 0.2, 4.0);
  halves.add(0, ball(from, speed));
  CHECK(halves.parts[0]->has(0));
  CHECK_FALSE(halves.parts[1]->has(0));  // too far away to be of interest
  double worst = 0.0;
  double apart = 0.0;
  for (int k = 0; k < 80; ++k) {
    halves.step();
    const pbd::BodyState* state = halves.decided(0);
    REQUIRE(state != nullptr);
    const double t = halves.time();
    const Vec3 truth = from + t * speed + 0.5 * t * t * Vec3(0.0, 0.0, -9.81);
    worst = std::max(worst, (state->pose.position - truth).norm());
    if (halves.parts[0]->has(0) && halves.parts[1]->has(0)) {
      const Vec3 way =
          halves.parts[0]->state(0).pose.position - halves.parts[1]->state(0).pose.position;
      apart = std::max(apart, way.norm());
    }
  }
  // The scheme's own error over 80 steps of free fall, g t h / 2 with h a quarter of a frame.
  const double own = 0.5 * 9.81 * halves.time() * kFrame / 4.0;
  CHECK(worst < own + 2e-3);
  CHECK(apart < 2e-3);
  CHECK_FALSE(halves.parts[0]->has(0));
  CHECK(halves.parts[1]->has(0));
  CHECK(halves.parts[1]->partition->stats().own == 1);
  CHECK(halves.parts[0]->partition->stats().vanished == 1);
  CHECK(halves.parts[1]->partition->stats().appeared == 1);
}

TEST_CASE("partition: a blow across the border keeps momentum", "[consensus]") {
  const double latency = GENERATE(0.0, 0.001);
  const double place = GENERATE(-0.15, 0.0, 0.1);  // m, of the blow
  CAPTURE(latency, place);
  Halves halves({.latency = latency}, kWeightless);
  const double speed = 2.0;
  halves.add(0, ball(Vec3(place - 1.1, 0.0, 0.0), Vec3(speed, 0.0, 0.0)));
  halves.add(1, ball(Vec3(place + 0.1, 0.0, 0.0)));
  double nearest = 1.0;
  for (int k = 0; k < 60; ++k) {
    halves.step();
    const pbd::BodyState* a = halves.decided(0);
    const pbd::BodyState* b = halves.decided(1);
    REQUIRE(a != nullptr);
    REQUIRE(b != nullptr);
    nearest = std::min(nearest, (a->pose.position - b->pose.position).norm());
  }
  // No restitution: both go on together with half the speed.
  const double v0 = halves.decided(0)->twist.linear.x();
  const double v1 = halves.decided(1)->twist.linear.x();
  CHECK(v0 + v1 == Approx(speed).epsilon(0.03));
  CHECK(std::abs(v1 - v0) < 0.05 * speed);
  CHECK(nearest > 2.0 * kBallRadius - 0.1 * kBallRadius);
}

TEST_CASE("partition: nobody lets go of a ball that nobody else has", "[consensus][fault]") {
  Halves halves({}, kWeightless);
  halves.network.cut(1, 2);
  halves.add(0, ball(Vec3(-1.5, 0.0, 0.0), Vec3(4.0, 0.0, 0.0)));
  for (int k = 0; k < 120; ++k) {
    halves.step();
    REQUIRE(halves.parts[0]->has(0));
  }
  CHECK(halves.parts[0]->state(0).pose.position.x() == Approx(6.5).epsilon(1e-6));
  CHECK_FALSE(halves.parts[1]->has(0));
  // Mended, it goes over.
  halves.network.heal(1, 2);
  for (int k = 0; k < 60; ++k) halves.step();
  CHECK_FALSE(halves.parts[0]->has(0));
  REQUIRE(halves.parts[1]->has(0));
  CHECK(halves.parts[1]->state(0).pose.position.x() == Approx(10.5).epsilon(1e-3));
}

TEST_CASE("partition: what a peer without a cell tells of appears nowhere", "[consensus][fault]") {
  StubTransport transport(1);
  std::vector<PartitionCell> cells(2);
  cells[0].peer = 1;
  cells[0].cell.max.x() = 0.0;
  cells[1].peer = 2;
  cells[1].cell.min.x() = 0.0;
  Part part(transport, cells, kWeightless, {});
  StateUpdate update;
  update.pose.position = Vec3(-0.1, 0.0, 0.0);
  update.influence = 1.0F;
  SessionTime now = kStart;
  const auto tell = [&](PeerId from, int ball_number) {
    update.id = id_of(ball_number);
    update.stamp = now;
    transport.deliver(from, update);
    part.step(now, now + ns(kFrame));
    now += ns(kFrame);
  };
  for (int k = 0; k < 10; ++k) tell(3, 0);
  CHECK_FALSE(part.has(0));
  CHECK(part.partition->stats().appeared == 0);
  // The same of a peer that has one is taken in.
  tell(2, 1);
  CHECK(part.has(1));
  CHECK(part.partition->stats().appeared == 1);
}

TEST_CASE("partition: borders that move take the bodies along", "[consensus]") {
  Halves halves({.latency = 0.001}, kWeightless);
  for (int i = 0; i < 10; ++i) halves.add(i, ball(Vec3(-5.0 + 1.0 * i, 0.0, 0.0)));
  for (int k = 0; k < 30; ++k) halves.step();
  CHECK(halves.parts[1]->partition->stats().own == 4);
  std::vector<PartitionCell> cells(2);
  cells[0].peer = 1;
  cells[0].cell.max.x() = -3.5;
  cells[1].peer = 2;
  cells[1].cell.min.x() = -3.5;
  for (const auto& part : halves.parts) part->partition->set_cells(cells);
  for (int k = 0; k < 90; ++k) {
    halves.step();
    for (int i = 0; i < 10; ++i) REQUIRE((halves.parts[0]->has(i) || halves.parts[1]->has(i)));
  }
  CHECK(halves.parts[0]->partition->stats().own == 2);
  CHECK(halves.parts[1]->partition->stats().own == 8);
  for (int i = 0; i < 10; ++i) {
    const Part& there = *halves.parts[i < 2 ? 0 : 1];
    REQUIRE(there.has(i));
    CHECK((there.state(i).pose.position - Vec3(-5.0 + 1.0 * i, 0.0, 0.0)).norm() < 1e-6);
  }
}

}  // namespace
}  // namespace tandem::consensus::partition_test
