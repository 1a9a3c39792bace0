// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Peers of a server that speak by UDP where they can.
#include <numeric>
#include <thread>

#include "nats/peers.h"
#include "nats/udp_line.h"
#include "support/bodies.h"

namespace tandem::nats::direct_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

NatsOptions direct_options(std::uint16_t server, PeerId self) {
  NatsOptions out = options_of(server, self);
  out.server.direct = DirectOptions{.listen_address = "127.0.0.1", .reachable_at = {}};
  return out;
}

/// Two of them, and a line between them that loses.
class Neighbours {
 public:
  Neighbours() {
    const auto start = [&](PeerId self) {
      NatsOptions options = direct_options(server.port(), self);
      options.server.direct->reachable_at = {{"127.0.0.1", line.port()}};
      return std::make_unique<NatsTransport>(options);
    };
    a = start(1);
    b = start(2);
    line.join(a->status().hub.direct_port, b->status().hub.direct_port);
    REQUIRE(eventually([&] { return linked(*a, *b); }));
  }
  bool direct() { return a->status().direct == 1 && b->status().direct == 1; }
  /// The first says the next number 100 times a second.
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      REQUIRE(a->post(2, numbered(next++), Delivery::Reliable));
      a->post(2, numbered(1'000'000 + next), Delivery::Newest);
      hear();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  void hear() {
    std::vector<Packet> packets;
    a->drain(packets);
    packets.clear();
    b->drain(packets);
    for (const Packet& packet : packets) {
      const std::uint64_t value = number_of(packet);
      (value < 1'000'000 ? reliable : states).push_back(value);
    }
  }
  void check_all_once() {
    REQUIRE(eventually([&] {
      hear();
      return reliable.size() >= next;
    }));
    std::vector<std::uint64_t> all(next);
    std::iota(all.begin(), all.end(), 0);
    CHECK(reliable == all);
    std::ranges::sort(states);
    CHECK(std::ranges::adjacent_find(states) == states.end());
  }

  Server server;
  UdpLine line{5};
  std::unique_ptr<NatsTransport> a;
  std::unique_ptr<NatsTransport> b;
  std::uint64_t next = 0;
  std::vector<std::uint64_t> reliable;
  std::vector<std::uint64_t> states;
};

TEST_CASE(
    "nats: the near speak by UDP, and over the server where that loses too much: each word "
    "comes once",
    "[nats][fault]") {
  if (!has_server()) return;
  Neighbours pair;
  REQUIRE(eventually([&] {
    pair.run(1);
    return pair.direct();
  }));
  // Over the server goes who is where, ten times a second, and little else. A machine that stands
  // still makes them doubt the way for a while.
  CHECK(eventually([&] {
    const NatsStatus before = pair.a->status();
    pair.run(50);
    const NatsStatus after = pair.a->status();
    return after.direct_out - before.direct_out > 50 && after.direct_in > before.direct_in &&
           after.hub.messages_out - before.hub.messages_out < 30;
  }));
  pair.line.lose(0.3);
  pair.run(150);
  pair.line.lose(1.0);
  pair.run(200);
  CHECK_FALSE(pair.direct());
  pair.line.lose(0.0);
  CHECK(eventually([&] {
    pair.run(1);
    return pair.direct();
  }));
  CHECK(linked(*pair.a, *pair.b));
  pair.check_all_once();
}

TEST_CASE("nats: near peers go on by UDP while there is no server", "[nats][fault]") {
  if (!has_server()) return;
  Neighbours pair;
  REQUIRE(eventually([&] {
    pair.run(1);
    return pair.direct();
  }));
  pair.server.kill();
  REQUIRE(eventually([&] { return !pair.a->status().hub.connected; }));
  const std::size_t heard = pair.states.size();
  pair.run(100);
  pair.check_all_once();
  CHECK(pair.states.size() > heard + 90);
  pair.server.start();
  pair.run(50);
  pair.check_all_once();
  CHECK(linked(*pair.a, *pair.b));
}

TEST_CASE("nats: strangers' packets to the UDP port are counted, dropped and harm no other",
          "[nats][fault]") {
  if (!has_server()) return;
  Neighbours pair;
  REQUIRE(eventually([&] {
    pair.run(1);
    return pair.direct();
  }));
  const std::uint16_t port = pair.b->status().hub.direct_port;
  const std::uint64_t before = pair.b->status().unknown;
  constexpr int kEach = 50;
  for (int i = 0; i < kEach; ++i) {
    pair.run(1);
    std::vector<char> bytes = pair.line.last();
    UdpLine::intrude(port, bytes);  // had before
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    UdpLine::intrude(port, bytes);  // forged
    for (int k = 0; k < 20; ++k) {  // of nobody here
      UdpLine::intrude(port, std::vector<char>(static_cast<std::size_t>(k), 'a'));
    }
  }
  CHECK(eventually([&] { return pair.b->status().hub.direct_unknown >= kEach * 20; }));
  CHECK(eventually([&] { return pair.b->status().unknown - before >= kEach; }));
  CHECK(pair.direct());
  CHECK(pair.b->status().dropped == 0);
  CHECK(linked(*pair.a, *pair.b));
  pair.check_all_once();
}

TEST_CASE("nats: only the nearest of the near peers use UDP", "[nats]") {
  if (!has_server()) return;
  Server server;
  NatsOptions one = direct_options(server.port(), 1);
  one.direct_peers = 1;
  NatsTransport a(one);
  NatsTransport b(direct_options(server.port(), 2));
  NatsTransport c(direct_options(server.port(), 3));
  b.set_position(Vec3(1.0, 0.0, 0.0));
  c.set_position(Vec3(4.0, 0.0, 0.0));
  // The third wants the first, who has no room for it.
  REQUIRE(eventually([&] { return linked(a, b) && linked(a, c) && a.status().direct == 1; }));
  REQUIRE(eventually([&] { return b.status().direct == 2; }));
  std::this_thread::sleep_for(std::chrono::seconds(3));
  CHECK(c.status().direct == 1);
  b.set_position(Vec3(6.0, 0.0, 0.0));
  CHECK(eventually([&] { return c.status().direct == 2 && a.status().direct == 1; }));
  CHECK((linked(a, b) && linked(a, c)));
}

TEST_CASE("nats: an end without UDP is spoken to over the server", "[nats]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(direct_options(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  NatsOptions none = direct_options(server.port(), 3);
  none.direct_peers = 0;
  NatsTransport c(none);
  REQUIRE(eventually([&] { return linked(a, b) && linked(a, c); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(800));
  CHECK(a.status().direct == 0);
  CHECK(c.status().direct == 0);
  CHECK(a.post(2, numbered(5), Delivery::Reliable));
  std::vector<Packet> packets;
  REQUIRE(eventually([&] {
    b.drain(packets);
    return !packets.empty();
  }));
  CHECK(number_of(packets.front()) == 5);
}

TEST_CASE("nats: invalid options of UDP are refused by name", "[nats][fault]") {
  NatsOptions options = direct_options(4222, 1);
  options.server.direct->listen_address = "nowhere";
  CHECK(names(refusal([&] { options.validate(); }), "listen_address", "nowhere", "numeric"));
  options = direct_options(4222, 1);
  options.server.direct->reachable_at = {{"127.0.0.1", 0}};
  CHECK(names(refusal([&] { options.validate(); }), "reachable_at", "127.0.0.1:0", "ports"));
  options.server.direct->reachable_at.assign(5, {"127.0.0.1", 7});
  CHECK(names(refusal([&] { options.validate(); }), "reachable_at", "5", "at most 4"));
  options = direct_options(4222, 1);
  options.direct_peers = 1000;
  CHECK(names(refusal([&] { options.validate(); }), "direct_peers", "1000", "256"));
}

}  // namespace
}  // namespace tandem::nats::direct_test
