// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is sent in few bytes, within a budget, and when it is due.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "peer_fixture.h"
#include "stub_transport.h"
#include "support/catch.h"
#include "tandem/consensus/compact.h"

namespace sending_test {

using namespace tandem::consensus;
using namespace tandem::consensus::testing;
using tandem::pbd::BodyId;

namespace {

PeerOptions compact(double tolerance = 0.0, double kbit_per_s = 0.0) {
  PeerOptions options;
  options.sending.format = StateFormat::Compact;
  options.sending.tolerance = tolerance;
  options.sending.kbit_per_s = kbit_per_s;
  return options;
}

SharedId id_of(int i) { return SharedId::from_name("ball/" + std::to_string(i)); }

/// Peers 1 and 2, whose steps are not of one time, without gravity.
void add_pair(Session& session, const PeerOptions& options) {
  session.add(1, 0.0, options, kWeightless);
  session.add(2, 0.004, options, kWeightless);
}

/// `count` balls in a row, at rest or flying apart from each other; without gravity.
std::vector<BodyId> add_balls(Site& site, int count, double off, const Vec3& velocity = {0, 0, 0}) {
  std::vector<BodyId> bodies;
  for (int i = 0; i < count; ++i) {
    const Vec3 v = (1.0 + 0.1 * i) * velocity;
    bodies.push_back(site.world.add_body(ball({0.5 * i, off, 0.0}, v)));
    site.peer->share({.id = id_of(i), .body = bodies.back()});
  }
  return bodies;
}

double worst_gap(const Site& a, const std::vector<BodyId>& in_a, const Site& b,
                 const std::vector<BodyId>& in_b) {
  double worst = 0.0;
  const double ahead = 1e-9 * static_cast<double>(a.world_time() - b.world_time());
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    const Vec3 there = b.world.pose(in_b[i]).position + ahead * b.world.twist(in_b[i]).linear;
    worst = std::max(worst, (a.world.pose(in_a[i]).position - there).norm());
  }
  return worst;
}

/// Bytes that peer 1 has posted.
std::uint64_t bytes_of(const Session& session) {
  return session.sites[0]->peer->stats().bytes_sent;
}

}  // namespace

TEST_CASE("sending: cubes that rest in agreement neither move nor wake for being rounded",
          "[consensus]") {
  // Nowhere near the lattice, in position and orientation.
  const Quat turned(Eigen::AngleAxisd(0.123456, Vec3::UnitZ()));
  const Vec3 at(0.12345678, 0.23456789, kHalf.z() - 1.23e-5);
  for (const double tolerance : {0.0, 1e-3}) {
    INFO("tolerance " << tolerance);
    Session session({.latency = 0.03});
    for (PeerId id = 1; id <= 2; ++id) {
      Site& site = session.add(id, id == 1 ? 0.0 : 0.006, compact(tolerance));
      site.share(cube(at, turned));
      put_on_plane(site);
    }
    session.run(3.0);
    const Pose before = session[0].pose();
    const Pose other = session[1].pose();
    CHECK_FALSE(session[0].world.awake(session[0].body));
    session.run(5.0);
    for (auto& site : session.sites) CHECK_FALSE(site->world.awake(site->body));
    CHECK(session[0].x() == before.position);
    CHECK(session[1].x() == other.position);
    CHECK(gap(session[0], session[1]) < kPositionQuantum);
    CHECK(session[0].peer->stats().updates_received > 0);
  }
}

TEST_CASE("sending: copies at one place off the lattice are not drawn to it", "[consensus]") {
  const Quat turned(Eigen::AngleAxisd(1.23456, Vec3(1.0, 2.0, -1.0).normalized()));
  const Vec3 at(0.3 / 4096.0, 7.6 / 4096.0, -3.4 / 4096.0);
  Session session({.latency = 0.03});
  for (PeerId id = 1; id <= 2; ++id) {
    Site& site = session.add(id, id == 1 ? 0.0 : 0.006, compact(), kWeightless);
    site.share(cube(at, turned));  // nothing holds it
  }
  session.run(4.0);
  CHECK(session[0].peer->stats().bodies_aggregated > 100);
  for (auto& site : session.sites) {
    CHECK((site->x() - at).norm() < 1e-9);
    CHECK(site->pose().orientation.angularDistance(turned) < 1e-7);
  }
}

TEST_CASE("sending: a damped body comes to rest though its velocity is rounded", "[consensus]") {
  // In a step the damping takes less than half a quantum from here on: 40 mm/s.
  constexpr double kDamping = 0.8;  // 1/s
  constexpr double kSeconds = 8.0;
  const Vec3 v(0.03, 0.01, 0.0);
  Session session({.latency = 0.01});
  for (PeerId id = 1; id <= 3; ++id) {
    Site& site = session.add(id, 0.004 * static_cast<double>(id - 1), compact(), kWeightless);
    tandem::pbd::BodyDef def = ball(Vec3::Zero(), v);
    def.twist.angular = Vec3(0.02, -0.03, 0.0);
    def.linear_damping = kDamping;
    def.angular_damping = kDamping;
    site.share(def);
  }
  session.run(kSeconds);
  const double left = std::exp(-kDamping * kSeconds);
  for (auto& site : session.sites) {
    INFO("peer " << site->id);
    CHECK(site->v().norm() <= 1.2 * left * v.norm());
    // Half a step of the way at the start, as long again for the phases, and half a quantum.
    const double tolerance = v.norm() / 60.0 + 0.5 * kPositionQuantum;
    CHECK((site->x() - v / kDamping).norm() < tolerance);
  }
}

TEST_CASE("sending: rounded states agree as well as full ones", "[consensus]") {
  const auto gap_after = [](const PeerOptions& options) {
    Session session({.latency = 0.05, .jitter = 0.002});
    add_pair(session, options);
    const auto a = add_balls(session[0], 8, 0.0, {0.0, 0.0, 0.7});
    const auto b = add_balls(session[1], 8, 0.05, {0.0, 0.0, 0.7});
    session.run(6.0);
    return worst_gap(session[0], a, session[1], b);
  };
  const double full = gap_after({});
  const double rounded = gap_after(compact());
  CHECK(full < 1e-3);
  // Half a quantum of position, and of velocity over the time that news is old: 50 ms and a step.
  CHECK(rounded < full + std::sqrt(3.0) * (0.5 / 4096.0 + 0.07 * 0.5 / 1024.0));
}

TEST_CASE("sending: a predicted state is not sent, and a change comes at once", "[consensus]") {
  PeerOptions options = compact(1e-3);
  options.sending.refresh = 0.5;
  Session session({.latency = 0.02});
  add_pair(session, options);
  const auto a = add_balls(session[0], 20, 0.0, {0.0, 0.0, 1.0});
  const auto b = add_balls(session[1], 20, 0.0, {0.0, 0.0, 1.0});
  session.run(2.0);
  const LinkStats before = session[0].peer->stats().links.at(0);
  session.run(2.0);
  const LinkStats after = session[0].peer->stats().links.at(0);
  // Free flight at constant velocity: each body once in half a second.
  CHECK(after.states - before.states >= 20 * 3);
  CHECK(after.states - before.states <= 20 * 5);
  CHECK(after.unchanged > 20 * 200);

  // A hit that the other side knows nothing of.
  session[0].world.set_twist(a[7], {Vec3(0.0, 3.0, 1.0), Vec3::Zero()});
  session.run(0.1);
  const LinkStats hit = session[0].peer->stats().links.at(0);
  CHECK(hit.states > after.states);
  session.run(0.5);
  CHECK(session[1].world.twist(b[7]).linear.y() > 0.5);
}

TEST_CASE("sending: a resting state is sent once and still counts as news", "[consensus]") {
  PeerOptions options = compact(1e-3);
  options.sending.rest_refresh = 60.0;
  Session session({.latency = 0.02});
  add_pair(session, options);
  const auto a = add_balls(session[0], 30, 0.0);
  const auto b = add_balls(session[1], 30, 0.0);
  session.run(2.0);
  const std::uint64_t states = session[0].peer->stats().links.at(0).states;
  const std::uint64_t bytes = bytes_of(session);
  session.run(10.0);
  // Ten seconds, no state, and a sign of life of 14 bytes ten times a second.
  CHECK(session[0].peer->stats().links.at(0).states == states);
  CHECK(bytes_of(session) - bytes <= 14 * 102);
  // The inbox drops what is older than a second; these still hold.
  CHECK(session[1].peer->heard(id_of(3), 1).has_value());
  CHECK(*session[1].peer->heard(id_of(3), 1) > session.network.now() - ns(0.2));

  // One copy is put aside by 3 cm, and comes back as if all had been sent in each step.
  session[1].world.set_pose(
      b[3], {session[1].world.pose(b[3]).position + Vec3(0.0, 0.03, 0.0), Quat::Identity()});
  session.run(3.0);
  CHECK(worst_gap(session[0], a, session[1], b) < 1.5e-3);
}

TEST_CASE("sending: after a long cut a peer learns the resting states again", "[consensus]") {
  PeerOptions options = compact(1e-3);
  options.sending.rest_refresh = 600.0;
  Session session({.latency = 0.02});
  add_pair(session, options);
  add_balls(session[0], 5, 0.0);
  const auto b = add_balls(session[1], 5, 0.0);
  session.run(2.0);
  // One direction alone is lossy beyond use: neither side sees that.
  session.network.set_link(1, 2, {.latency = 0.02, .loss = 0.99});
  session.run(8.0);
  session.network.set_link(1, 2, {.latency = 0.02});
  session.run(4.0);
  REQUIRE(session[1].peer->heard(id_of(3), 1).has_value());
  CHECK(*session[1].peer->heard(id_of(3), 1) > session.network.now() - ns(0.2));
}

TEST_CASE("sending: the budget is kept, and held bodies come first", "[consensus]") {
  constexpr int kBalls = 60;
  constexpr double kBudget = 64.0;  // kbit/s
  PeerOptions options = compact(0.0, kBudget);
  Session session({.latency = 0.02});
  add_pair(session, options);
  const auto a = add_balls(session[0], kBalls, 0.0, {0.0, 0.0, 0.5});
  const auto b = add_balls(session[1], kBalls, 0.02, {0.0, 0.0, 0.5});
  session.run(1.0);
  session[0].peer->grab({.body = id_of(kBalls - 1),
                         .anchor_w = session[0].world.pose(a.back()).position + Vec3(0, 1, 0),
                         .stiffness = 20.0});
  const auto told = [&] {
    const auto& links = session[0].peer->stats().links;
    return links.at(0);
  };
  const LinkStats before = told();
  const std::uint64_t packets = session.network.counters(1, 2).posted;
  const std::uint64_t bytes = bytes_of(session);
  constexpr double kSeconds = 4.0;
  session.run(kSeconds);
  const LinkStats after = told();
  const double sent = static_cast<double>(bytes_of(session) - bytes) +
                      74.0 * static_cast<double>(session.network.counters(1, 2).posted - packets);
  const double allowed = 125.0 * kBudget * kSeconds;
  CHECK(sent <= 1.05 * allowed + 600.0);
  CHECK(sent >= 0.8 * allowed);  // and used
  CHECK(after.deferred > before.deferred);
  CHECK(after.states > before.states);
  // All get their turn: the copies come together.
  CHECK(worst_gap(session[0], a, session[1], b) < 0.02);
}

TEST_CASE("sending: a late peer learns all names despite loss", "[consensus]") {
  Session session({.latency = 0.03, .loss = 0.25, .reorder = 0.2});
  session.add(1, 0.0, compact(1e-3), kWeightless);
  const auto a = add_balls(session[0], 40, 0.0);
  session.run(3.0);
  session.add(2, 0.003, compact(1e-3), kWeightless);
  const auto b = add_balls(session[1], 40, 0.02);
  session.run(4.0);
  CHECK(session[1].peer->stats().unknown_ids == 0);
  CHECK(worst_gap(session[0], a, session[1], b) < 2e-3);
}

TEST_CASE("sending: an index never means another body than it was given to", "[consensus][fault]") {
  // The same peer twice: in its second life it has other bodies in another order.
  tandem::pbd::World world(kWeightless);
  StubTransport transport(2);
  PeerOptions options;
  options.authority_ramp = 0.0;
  Peer peer(world, transport, options);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 3; ++i) {
    bodies.push_back(world.add_body(ball({1.0 * i, 0.0, 0.0})));
    peer.share({.id = id_of(i), .body = bodies.back()});
  }
  tandem::pbd::Solver solver(without_clock());
  SessionTime now = kStart;
  const auto step = [&] {
    peer.before_step(now);
    solver.step(world, 1.0 / 60.0);
    now += ns(1.0 / 60.0);
    peer.after_step(now);
  };
  const auto state = [&](std::uint32_t table, std::uint16_t index) {
    IndexedState out{index, {.pose = {{9.0, 9.0, 9.0}, Quat::Identity()}, .influence = 0.4f}};
    out.update.stamp = now;
    std::vector<std::byte> bytes;
    encode_compact(std::span(&out, 1), table, 4096, bytes);
    transport.inbox.push_back({1, bytes});
  };
  const auto names = [&](std::uint32_t table, std::uint16_t first, std::vector<SharedId> ids) {
    std::vector<std::byte> bytes;
    encode_indices(table, first, ids, bytes);
    transport.inbox.push_back({1, bytes});
  };
  const auto heard = [&](int i) { return peer.heard(id_of(i), 1).has_value(); };
  step();
  state(100, 0);  // before any name
  step();
  CHECK(peer.stats().unknown_indices == 1);
  names(100, 0, {id_of(0), id_of(1)});
  state(100, 1);
  state(100, 2);  // beyond what was named
  state(101, 0);  // of a table that is not there yet
  step();
  CHECK(peer.stats().unknown_indices == 3);
  CHECK_FALSE(heard(0));
  CHECK(heard(1));
  CHECK_FALSE(heard(2));
  names(101, 1, {id_of(2)});
  state(100, 0);  // late, of the first life
  state(101, 0);  // what 0 means now has not been said
  state(101, 1);
  step();
  CHECK(peer.stats().unknown_indices == 5);
  CHECK_FALSE(heard(0));
  CHECK(heard(2));
  CHECK(transport.dropped.empty());
  // A peer that keeps sending without its names is asked for them, but not in each step.
  transport.posted.clear();
  for (int i = 0; i < 90; ++i) {
    state(102, 0);
    step();
  }
  int asked = 0;
  DecodedPacket packet;
  for (const auto& bytes : transport.posted) {
    REQUIRE(decode(bytes, packet).ok());
    asked += static_cast<int>(packet.indices_wanted.size());
  }
  CHECK((asked >= 1 && asked <= 3));
}

TEST_CASE("sending: a sphere shared without orientation is not turned", "[consensus]") {
  for (const bool matters : {true, false}) {
    Session session({.latency = 0.02});
    for (PeerId id = 1; id <= 2; ++id) {
      Site& site = session.add(id, id == 1 ? 0.0 : 0.005, compact(), kWeightless);
      tandem::pbd::BodyDef def = ball({0.0, 0.0, 0.0});
      if (id == 2) {
        def.pose.position.y() = 0.05;
        def.pose.orientation = Quat(Eigen::AngleAxisd(0.4, Vec3::UnitX()));
      }
      site.body = site.world.add_body(def);
      site.peer->share({.id = kBody, .body = site.body, .orientation = matters});
    }
    session.run(3.0);
    CHECK(gap(session[0], session[1]) < 1e-3);
    const double angle =
        session[0].pose().orientation.angularDistance(session[1].pose().orientation);
    if (matters) CHECK(angle < 0.01);
    if (!matters) CHECK(angle == Approx(0.4).margin(1e-3));
  }
}

TEST_CASE("sending: springs' anchors arrive in few bytes and hold the body as in full",
          "[consensus]") {
  const auto run = [](const PeerOptions& options) {
    Session session({.latency = 0.03});
    for (PeerId id = 1; id <= 2; ++id) {
      session.add(id, id == 1 ? 0.0 : 0.005, options, kWeightless).share(ball({0.0, 0.0, 0.0}));
    }
    const GrabId grab = session[0].peer->grab({.body = kBody, .stiffness = 50.0, .damping = 5.0});
    session[0].user = [grab](Site& site, SessionTime now) {
      const double t = 1e-9 * static_cast<double>(now - kStart);
      site.peer->move(grab, {0.5 * t, 0.1 * std::sin(3.0 * t), 0.0}, now);
    };
    session.run(4.0);
    CHECK(session[1].peer->held(kBody));
    return std::pair(gap_now(session[0], session[1]), bytes_of(session));
  };
  const auto [full_gap, full_bytes] = run({});
  const auto [small_gap, small_bytes] = run(compact());
  CHECK(small_gap < full_gap + 1e-3);
  CHECK(2 * small_bytes < full_bytes);
}

TEST_CASE("sending: options that are not valid are named", "[consensus][fault]") {
  PeerOptions options;
  options.sending.kbit_per_s = 1.0;
  CHECK_THROWS_WITH(options.validate(),
                    Catch::Contains("SendOptions") && Catch::Contains("kbit_per_s"));
  options = {};
  options.sending.tolerance = -1.0;
  CHECK_THROWS_WITH(options.validate(), Catch::Contains("tolerance"));
  options = {};
  options.sending.angle_tolerance = 0.0;
  CHECK_THROWS_WITH(options.validate(), Catch::Contains("angle_tolerance"));
}

}  // namespace sending_test
