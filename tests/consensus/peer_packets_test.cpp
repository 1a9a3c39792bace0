// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Packets that fit what the transport takes.
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

}  // namespace

TEST_CASE("peer: packets are cut to what the transport takes, and say the same", "[consensus]") {
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
