// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Packets that fit what the transport takes.
#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "peer_fixture.h"
#include "support/catch.h"

namespace peer_packets_test {

using namespace tandem::consensus;
using namespace tandem::consensus::testing;
using tandem::pbd::BodyId;

namespace {

constexpr int kBalls = 23;
constexpr std::size_t kSmall = 502;  // bytes: an MTU of 576

struct Outcome {
  std::vector<Vec3> positions;  ///< of both peers' bodies
  std::uint64_t packets = 0;    ///< on the way from peer 1 to peer 2
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_sent = 0;
};

/// Two peers whose balls fly along a little apart, one of them held by a spring.
Outcome fly(std::size_t max_state_bytes, const PeerOptions& options = {}) {
  Session session({.latency = 0.02, .max_state_bytes = max_state_bytes});
  session.add(1, 0.0, options, kWeightless);
  session.add(2, 0.005, options, kWeightless);
  std::vector<std::pair<const Site*, BodyId>> balls;
  for (auto& site : session.sites) {
    for (int i = 0; i < kBalls; ++i) {
      const double off = site->id == 1 ? 0.0 : 0.01 * (i + 1);
      const BodyId body = site->world.add_body(ball({1.0 * i, off, 0.0}, {0.0, 0.0, 1.0}));
      site->peer->share({.id = SharedId::from_name("ball/" + std::to_string(i)), .body = body});
      balls.emplace_back(site.get(), body);
    }
  }
  for (int i = 0; i < 9; ++i) {
    session[0].peer->grab({.body = SharedId::from_name("ball/" + std::to_string(i)),
                           .anchor_w = {1.0 * i, 0.0, 1.0},
                           .stiffness = 5.0});
  }
  session.run(2.0);
  Outcome outcome;
  for (const auto& [site, body] : balls) {
    outcome.positions.push_back(site->world.pose(body).position);
  }
  outcome.packets = session.network.counters(1, 2).posted;
  for (const PeerStatus& status : session.network.transport(1).peers()) {
    outcome.bytes_in += status.bytes_out;
  }
  outcome.bytes_sent = session[0].peer->stats().bytes_sent;
  return outcome;
}

/// Another transport whose packets, reliable ones too, must be short.
class NarrowTransport final : public Transport {
 public:
  NarrowTransport(Transport& below, std::size_t most) : below_(below), most_(most) {}
  std::size_t longest = 0;  ///< bytes, of what was offered
  double kbit_per_s = 0.0;  ///< that it says it bears; 0: says nothing

  PeerId self() const override { return below_.self(); }
  bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) override {
    longest = std::max(longest, bytes.size());
    return bytes.size() <= most_ && below_.post(to, bytes, delivery);
  }
  std::size_t max_packet_bytes(Delivery) const override { return most_; }
  void drain(std::vector<Packet>& out) override { below_.drain(out); }
  void drop(PeerId peer, const std::string& reason) override { below_.drop(peer, reason); }
  std::vector<PeerStatus> peers() const override {
    std::vector<PeerStatus> out = below_.peers();
    for (PeerStatus& status : out) status.kbit_per_s = kbit_per_s;
    return out;
  }

 private:
  Transport& below_;
  std::size_t most_;
};

constexpr double kHandSpeed = 0.3;  // m/s

SharedId crowd_id(int i) { return SharedId::from_name("crowd/" + std::to_string(i)); }
Vec3 hand_at(int i, double t) { return {0.5 * i, kHandSpeed * t, 0.0}; }

struct Crowd {
  int held = 0;             ///< hands that peer 2 has had all the time
  double worst_lag = 0.0;   ///< m, of any hand at peer 2
  int heard = 0;            ///< bodies of which peer 2 has a new state in the end
  std::size_t longest = 0;  ///< bytes, of packets that were offered
};

struct Setting {
  int bodies = 0;
  int hands = 0;
  double kbit_per_s = 0.0;        ///< budget; 0: none
  double known_kbit_per_s = 0.0;  ///< what the transport says after 3 s; 0: nothing
  std::size_t packet = kSmall;    ///< bytes, the longest
};

/// Peer 1 of two holds the first of the bodies, and its hands move.
Crowd gather(const Setting& setting) {
  const int bodies = setting.bodies;
  const int hands = setting.hands;
  PeerOptions options;
  options.sending.format = StateFormat::Compact;
  options.sending.kbit_per_s = setting.kbit_per_s;
  std::vector<std::unique_ptr<NarrowTransport>> narrow;  // outlive the peers
  Session session({.latency = 0.02});
  for (const PeerId id : {PeerId{1}, PeerId{2}}) {
    narrow.push_back(
        std::make_unique<NarrowTransport>(session.network.transport(id), setting.packet));
    auto& site =
        session.sites.emplace_back(std::make_unique<Site>(*narrow.back(), options, kWeightless));
    site->first = kStart + ns(id == 1 ? 0.0 : 0.005);
    for (int i = 0; i < bodies; ++i) {
      site->peer->share({.id = crowd_id(i), .body = site->world.add_body(ball(hand_at(i, 0.0)))});
    }
  }
  std::vector<GrabId> grabs;
  for (int i = 0; i < hands; ++i) {
    grabs.push_back(session[0].peer->grab(
        {.body = crowd_id(i), .anchor_w = hand_at(i, 0.0), .stiffness = 50.0, .damping = 5.0}));
  }
  session[0].user = [&](Site& site, SessionTime now) {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    for (int i = 0; i < hands; ++i) {
      site.peer->move(grabs[static_cast<std::size_t>(i)], hand_at(i, t), now);
    }
  };
  session.run(0.5);
  if (setting.known_kbit_per_s > 0.0) {
    session.run(2.5);
    for (const auto& transport : narrow) transport->kbit_per_s = setting.known_kbit_per_s;
  }
  Crowd crowd{.held = hands};
  std::vector<tandem::pbd::Tether::Def> springs;
  session.after = [&](Site& site) {
    if (site.id != 2) return;
    springs.clear();
    site.peer->springs(springs);
    crowd.held = std::min(crowd.held, static_cast<int>(springs.size()));
    const double t = 1e-9 * static_cast<double>(site.world_time() - kStart);
    for (const auto& spring : springs) {
      crowd.worst_lag = std::max(crowd.worst_lag, std::abs(spring.anchor_w.y() - kHandSpeed * t));
    }
  };
  session.run(3.0);  // longer than springs are kept in silence, and than until all is said again
  for (int i = 0; i < bodies; ++i) {
    const auto stamp = session[1].peer->heard(crowd_id(i), 1);
    if (stamp && *stamp > session.network.now() - ns(0.1)) ++crowd.heard;
  }
  for (const auto& transport : narrow) crowd.longest = std::max(crowd.longest, transport->longest);
  return crowd;
}

}  // namespace

TEST_CASE("peer: packets are cut to the transport's limit and carry the same content",
          "[consensus]") {
  const Outcome large = fly(64 * 1024);
  const Outcome small = fly(kSmall);
  CHECK(small.packets > 3 * large.packets);
  REQUIRE(small.positions.size() == 2 * kBalls);
  for (std::size_t i = 0; i < small.positions.size(); ++i) {
    CHECK(small.positions[i] == large.positions[i]);
  }
  // Nothing was refused: every byte that was posted is on its way.
  CHECK(small.bytes_in == small.bytes_sent);
  // And it matters: the balls of a session whose packets are lost stay apart.
  CHECK(std::abs(small.positions[kBalls - 1].y() - small.positions[2 * kBalls - 1].y()) < 0.01);
}

TEST_CASE("peer: names and hands get through where reliable packets are short, too",
          "[consensus]") {
  const Crowd crowd = gather({.bodies = 70, .hands = 30});
  CHECK(crowd.longest <= kSmall);
  CHECK(crowd.longest > kSmall - 30);  // and are full
  CHECK(crowd.heard == 70);
  CHECK(crowd.held == 30);
  CHECK(crowd.worst_lag < 0.002);
}

TEST_CASE("peer: hands take turns where the budget has no room for all", "[consensus]") {
  const Crowd crowd = gather({.bodies = 60, .hands = 60, .kbit_per_s = 300.0});
  CHECK(crowd.longest <= kSmall);
  CHECK(crowd.held == 60);
  CHECK(crowd.worst_lag < 0.002);
}

TEST_CASE("peer: more hands in one message than a budget saves up for go on credit",
          "[consensus]") {
  const Crowd crowd = gather({.bodies = 45, .hands = 45, .kbit_per_s = 100.0, .packet = 1154});
  CHECK(crowd.longest > 900);
  CHECK(crowd.held == 45);
  // A quarter of the budget has room for three such messages a second.
  CHECK(crowd.worst_lag < kHandSpeed * 0.4);
}

TEST_CASE("peer: packets sent before the rate was known are not charged to it", "[consensus]") {
  const Crowd crowd =
      gather({.bodies = 30, .hands = 30, .known_kbit_per_s = 300.0, .packet = 1154});
  CHECK(crowd.held == 30);
  CHECK(crowd.worst_lag < 0.002);
  CHECK(crowd.heard == 30);
}

TEST_CASE("virtual link: states above the limit are refused, reliable packets are not",
          "[consensus]") {
  VirtualNetwork network({.max_state_bytes = kSmall});
  Transport& a = network.transport(1);
  network.transport(2);
  const std::vector<std::byte> fits(kSmall);
  const std::vector<std::byte> long_one(kSmall + 1);
  CHECK(a.max_packet_bytes(Delivery::Newest) == kSmall);
  CHECK(a.post(2, fits, Delivery::Newest));
  CHECK_FALSE(a.post(2, long_one, Delivery::Newest));
  CHECK(a.max_packet_bytes(Delivery::Reliable) == kMaxPacketBytes);
  CHECK(a.post(2, long_one, Delivery::Reliable));

  // One number for all peers: the least.
  network.transport(3);
  network.set_link(1, 3, {.max_state_bytes = 300});
  network.set_link(3, 2, {.max_state_bytes = 200});
  CHECK(a.max_packet_bytes(Delivery::Newest) == 300);
  CHECK_THROWS_AS(network.set_link(1, 3, {.max_state_bytes = 0}), std::invalid_argument);
}

}  // namespace peer_packets_test
