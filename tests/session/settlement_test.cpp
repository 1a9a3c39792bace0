// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Copies that rest in different places: one peer's are elected, and the others take them over.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "support/catch.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/math.h"
#include "tandem/ragdoll.h"
#include "tandem/scene.h"

namespace tandem::settlement_test {
namespace {

using consensus::LinkOptions;
using consensus::PeerId;
using consensus::PeerOptions;
using consensus::SessionTime;
using consensus::SharedId;
using consensus::VirtualNetwork;
using pbd::Quat;
using pbd::Vec3;

constexpr SessionTime kStep = 16'666'667;  ///< ns

/// One peer, its scene and the shared bodies in it.
struct Site {
  Site(consensus::Transport& transport, const PeerOptions& options)
      : peer(std::make_unique<consensus::Peer>(scene.world(), transport, options)) {
    scene.add(HalfSpace{}, {.type = BodyType::Static});
  }
  BodyId share(const std::string& name, const collision::Shape& shape, const SolidDef& def) {
    bodies.push_back(scene.add(shape, def));
    peer->share({.id = SharedId::from_name(name), .body = bodies.back()});
    return bodies.back();
  }
  double asleep() const {
    const auto count = std::count_if(bodies.begin(), bodies.end(),
                                     [&](BodyId body) { return !scene.world().awake(body); });
    return static_cast<double>(count) / static_cast<double>(bodies.size());
  }

  Scene scene;
  std::unique_ptr<consensus::Peer> peer;
  std::vector<BodyId> bodies;
};

/// Peers that step 7 ms apart.
class Table {
 public:
  Table(const LinkOptions& link, std::uint64_t seed) : network(link, seed, 1'000'000'000) {}

  Site& add(const PeerOptions& options = {}) {
    const auto id = static_cast<PeerId>(sites.size() + 1);
    sites.push_back(std::make_unique<Site>(network.transport(id), options));
    return *sites.back();
  }
  void run(double seconds) {
    const auto steps = static_cast<int>(std::lround(60.0 * seconds));
    for (int step = 0; step < steps; ++step) {
      const SessionTime from = network.now();
      for (std::size_t i = 0; i < sites.size(); ++i) {
        network.advance_to(from + 7'000'000 * static_cast<SessionTime>(i));
        Site& site = *sites[i];
        const SessionTime now = network.now();
        if (wind && i + 1 == sites.size()) site.scene.world().apply_force(site.bodies[0], *wind);
        site.peer->before_step(now);
        site.scene.step(1e-9 * static_cast<double>(kStep));
        site.peer->after_step(now + kStep);
      }
      network.advance_to(from + kStep);
    }
  }
  /// m and rad: the most that two copies of a body are apart.
  std::pair<double, double> apart(std::size_t body) const {
    std::pair<double, double> most;
    for (const auto& a : sites) {
      for (const auto& b : sites) {
        const pbd::Pose& there = a->scene.pose(a->bodies[body]);
        const pbd::Pose& here = b->scene.pose(b->bodies[body]);
        most.first = std::max(most.first, (there.position - here.position).norm());
        most.second = std::max(most.second,
                               pbd::rotation_between(there.orientation, here.orientation).norm());
      }
    }
    return most;
  }

  VirtualNetwork network;
  std::vector<std::unique_ptr<Site>> sites;
  std::optional<Vec3> wind;  ///< N, on the first body of the last peer alone
};

/// Cubes that fall on a heap, each peer's added in an order of its own, and are kicked at one peer
/// each. @return a digest of where all of them are in the end
std::vector<double> drop_heap(Table& table, unsigned seed, std::size_t cubes) {
  std::mt19937 random(seed);
  const auto draw = [&](double most) {
    return most * (2.0 * (static_cast<double>(random()) / 4294967295.0) - 1.0);
  };
  std::vector<pbd::Pose> start;
  for (std::size_t i = 0; i < cubes; ++i) {
    const double x = draw(0.1);
    const double y = draw(0.1);
    const double turn = draw(1.0);
    start.push_back({Vec3(x, y, 0.1 + 0.06 * static_cast<double>(i)),
                     pbd::exp_map(Vec3(turn, draw(1.0), draw(1.0)))});
  }
  for (std::size_t peer = 0; peer < 3; ++peer) {
    Site& site = table.add();
    site.bodies.resize(cubes);
    for (std::size_t k = 0; k < cubes; ++k) {
      const std::size_t i = (k * 7 + peer * 11) % cubes;
      site.bodies[i] = site.scene.add(Box{0.05, 0.05, 0.05}, {.pose = start[i]});
      site.peer->share(
          {.id = SharedId::from_name("cube " + std::to_string(i)), .body = site.bodies[i]});
    }
  }
  table.run(4.0);
  for (std::size_t peer = 0; peer < 3; ++peer) {
    Site& site = *table.sites[peer];
    const Vec3 speed(draw(2.0), draw(2.0), 1.0 + draw(1.0));
    site.scene.set_twist(site.bodies[random() % cubes], {.linear = speed});
    table.run(0.5);
  }
  table.run(8.0);
  std::vector<double> digest;
  for (const auto& site : table.sites) {
    for (const BodyId body : site->bodies) {
      const Vec3& x = site->scene.pose(body).position;
      digest.insert(digest.end(), {x.x(), x.y(), x.z()});
    }
  }
  return digest;
}

TEST_CASE("settlement: a heap of three peers comes to lie the same way, and sleeps",
          "[session][long]") {
  for (const unsigned seed : {1U, 2U}) {
    constexpr std::size_t kCubes = 40;
    const LinkOptions link{.latency = 0.1235, .jitter = 0.005};
    Table table(link, seed);
    const std::vector<double> digest = drop_heap(table, seed, kCubes);
    double way = 0.0;
    double turn = 0.0;
    for (std::size_t i = 0; i < kCubes; ++i) {
      way = std::max(way, table.apart(i).first);
      turn = std::max(turn, table.apart(i).second);
    }
    INFO("seed " << seed << ": " << 1e3 * way << " mm, " << turn << " rad");
    CHECK(way < 1e-3);
    CHECK(turn < 0.0175);
    for (const auto& site : table.sites) CHECK(site->asleep() > 0.95);
    if (seed > 1) continue;
    Table again(link, seed);
    CHECK(drop_heap(again, seed, kCubes) == digest);
  }
}

TEST_CASE("settlement: ragdolls that two peers share lie still and sleep",
          "[session][regression]") {
  // Three of these six once trembled without end at 0.1 m/s, copies 2 mm apart.
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    Table table({.latency = 0.0285, .jitter = 0.0014, .loss = 0.05}, seed);
    std::vector<std::unique_ptr<Ragdoll>> dolls;
    for (int peer = 0; peer < 2; ++peer) {
      Site& site = table.add();
      dolls.push_back(std::make_unique<Ragdoll>(
          site.scene, RagdollDef{.pose = {.position = Vec3(0.0, 0.02 * seed, 1.2)}}));
      for (const BodyId body : dolls.back()->bodies()) {
        site.bodies.push_back(body);
        const std::string name = "part" + std::to_string(site.bodies.size());
        site.peer->share({.id = SharedId::from_name(name), .body = body});
      }
    }
    table.run(14.0);
    double way = 0.0;
    for (std::size_t i = 0; i < Ragdoll::kParts; ++i) way = std::max(way, table.apart(i).first);
    INFO("seed " << seed << ": " << 1e3 * way << " mm");
    CHECK(way < 1e-3);
    for (const auto& site : table.sites) CHECK(site->asleep() == 1.0);
  }
}

/// A cube on the floor at `x`, whose peer says what it likes and listens to nobody.
Site& add_liar(Table& table, double x) {
  Site& site = table.add({.coupling = consensus::Coupling::None});
  site.share("cube", Box{0.05, 0.05, 0.05}, {.pose = {.position = Vec3(x, 0.0, 0.05)}});
  return site;
}
Site& add_honest(Table& table) {
  Site& site = table.add({.authority_ramp = 0.0});
  site.share("cube", Box{0.05, 0.05, 0.05}, {.pose = {.position = Vec3(0.0, 0.0, 0.05)}});
  return site;
}
TEST_CASE("settlement: a rolling ball is not stopped by a peer with it at rest far away",
          "[session]") {
  const auto rolled = [](bool lied) {
    Table table({.latency = 0.03}, 1);
    if (lied) {
      Site& liar = table.add({.coupling = consensus::Coupling::None});
      liar.share("ball", Sphere{0.1}, {.pose = {.position = Vec3(5.0, 0.0, 0.1)}});
    }
    for (int i = 0; i < 2; ++i) {
      Site& site = table.add({.authority_ramp = 0.0});
      site.share("ball", Sphere{0.1},
                 {.pose = {.position = Vec3(0.0, 0.0, 0.1)},
                  .twist = {.linear = Vec3(0.3, 0.0, 0.0), .angular = Vec3(0.0, 3.0, 0.0)}});
    }
    table.wind = Vec3(1.0, 0.0, 0.0);  // keeps the two copies apart
    table.run(6.0);
    const Site& site = *table.sites.back();
    CHECK(site.peer->stats().bodies_placed == 0);
    return site.scene.pose(site.bodies[0]).position.x();
  };
  const double alone = rolled(false);
  CHECK(alone > 2.0);
  CHECK(rolled(true) == Approx(alone).epsilon(0.05));
}

/// An obstacle that keeps the cube from every mean.
void add_walls(Site& site) {
  for (const double x : {-0.08, 0.08}) {
    site.scene.add(Box{0.02, 0.5, 0.5},
                   {.type = BodyType::Static, .pose = {.position = Vec3(x, 0.0, 0.5)}});
  }
}

TEST_CASE("settlement: two honest peers do not elect a liar", "[session]") {
  Table table({.latency = 0.03}, 1);
  add_liar(table, 1.0);  // has the lowest id
  for (int i = 0; i < 2; ++i) add_walls(add_honest(table));
  table.run(8.0);
  for (std::size_t i = 1; i < 3; ++i) {
    const Site& honest = *table.sites[i];
    CHECK(honest.peer->stats().bodies_placed == 0);
    CHECK(std::abs(honest.scene.pose(honest.bodies[0]).position.x()) < 0.02);
  }
}

TEST_CASE("settlement: a peer that lies alternately gets one election in 5 s", "[session]") {
  Table table({.latency = 0.03}, 1);
  Site& liar = add_liar(table, 0.5);
  Site& honest = add_honest(table);
  add_walls(honest);
  for (int i = 0; i < 10; ++i) {
    table.run(2.0);
    liar.scene.set_pose(liar.bodies[0], {.position = Vec3(i % 2 == 0 ? -0.5 : 0.5, 0.0, 0.05)});
  }
  const std::uint64_t placed = honest.peer->stats().bodies_placed;
  INFO("placed " << placed);
  CHECK(placed >= 1);  // two know no majority
  CHECK(placed <= 4);
}

TEST_CASE("settlement: where a body cannot lie it is left alone, sleeps, and is counted",
          "[session]") {
  Table table({.latency = 0.03}, 1);
  Site& low = add_honest(table);
  Site& high = add_honest(table);
  // Only here: the other's cube lies on the floor below it.
  high.scene.add(Box{0.5, 0.5, 0.05},
                 {.type = BodyType::Static, .pose = {.position = Vec3(0.0, 0.0, 0.05)}});
  high.scene.set_pose(high.bodies[0], {.position = Vec3(0.0, 0.0, 0.15)});
  table.run(12.0);
  CHECK(low.scene.pose(low.bodies[0]).position.z() == Approx(0.05).margin(1e-3));
  CHECK(high.scene.pose(high.bodies[0]).position.z() == Approx(0.15).margin(1e-3));
  for (const auto& site : table.sites) CHECK(site->asleep() == 1.0);
  CHECK(low.peer->stats().bodies_placed == 0);
  CHECK(high.peer->stats().bodies_placed <= 2);
  CHECK(high.peer->stats().bodies_apart == 1);
}

}  // namespace
}  // namespace tandem::settlement_test
