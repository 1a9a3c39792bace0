// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Real servers on loopback, which come and go.
#include <chrono>
#include <numeric>
#include <thread>

#include "nats/peers.h"
#include "support/bodies.h"

namespace tandem::nats::transport_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

void drain_into(NatsTransport& transport, std::vector<std::uint64_t>& out) {
  std::vector<Packet> packets;
  transport.drain(packets);
  for (const Packet& packet : packets) out.push_back(number_of(packet));
}

std::vector<std::uint64_t> counted(std::size_t count) {
  std::vector<std::uint64_t> out(count);
  std::iota(out.begin(), out.end(), 0);
  return out;
}

TEST_CASE("nats: near peers meet, and reliable messages come once and in order", "[nats]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(options_of(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  REQUIRE(eventually([&] { return linked(a, b); }));
  for (std::uint64_t i = 0; i < 500; ++i) REQUIRE(a.post(2, numbered(i), Delivery::Reliable));
  std::vector<std::uint64_t> heard;
  REQUIRE(eventually([&] {
    drain_into(b, heard);
    return heard.size() >= 500;
  }));
  CHECK(heard == counted(500));
  heard.clear();
  REQUIRE(eventually([&] {
    a.post(2, numbered(1000, 1100), Delivery::Newest);
    drain_into(b, heard);
    return !heard.empty();
  }));
  CHECK(heard.front() == 1000);
  CHECK_FALSE(a.post(3, numbered(0), Delivery::Reliable));
  CHECK(status_of(a, 2).round_trip > 0);
  CHECK(std::abs(a.session_now() - b.session_now()) < 50'000'000);
}

TEST_CASE("nats: a peer that walks away is parted from, and met again on its return", "[nats]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(options_of(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  REQUIRE(eventually([&] { return linked(a, b); }));
  b.set_position(Vec3(100.0, 3.0, 0.0));
  REQUIRE(eventually([&] { return !status_of(a, 2).connected && !status_of(b, 1).connected; }));
  a.set_position(Vec3(101.0, 0.0, 0.0));
  REQUIRE(eventually([&] { return linked(a, b); }));
}

TEST_CASE("nats: a peer with another session key meets nobody", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(options_of(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  NatsOptions other = options_of(server.port(), 3);
  other.member.session_key = session_key(8);
  NatsTransport c(other);
  REQUIRE(eventually([&] { return linked(a, b); }));
  CHECK(eventually([&] { return a.status().refused > 3; }));
  CHECK(a.peers().size() == 1);
  CHECK(c.peers().empty());
}

TEST_CASE("nats: a server that is killed and started again costs no word, and no peer",
          "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  NatsTransport a(options_of(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  REQUIRE(eventually([&] { return linked(a, b); }));
  std::vector<std::uint64_t> heard;
  std::uint64_t next = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      REQUIRE(a.post(2, numbered(next++), Delivery::Reliable));
      drain_into(b, heard);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  };
  run(50);
  server.kill();
  run(100);
  CHECK_FALSE(a.status().hub.connected);
  server.start();
  run(50);
  REQUIRE(eventually([&] {
    drain_into(b, heard);
    return heard.size() >= next;
  }));
  CHECK(heard == counted(next));
  CHECK(a.status().hub.reconnects > 0);
  CHECK(linked(a, b));  // of the same connection: nobody has left
}

TEST_CASE("nats: a session begins where its server comes later", "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  server.kill();
  NatsTransport a(options_of(server.port(), 1));
  NatsTransport b(options_of(server.port(), 2));
  CHECK_FALSE(a.status().hub.connected);
  server.start();
  CHECK(eventually([&] { return linked(a, b); }));
}

TEST_CASE("nats: many peers of a process share one connection, and connect to the nearest alone",
          "[nats]") {
  if (!has_server()) return;
  Server server;
  const auto hub = std::make_shared<NatsHub>(HubOptions{.servers = {{"127.0.0.1", server.port()}}});
  std::vector<std::unique_ptr<NatsTransport>> peers;
  constexpr int kCount = 24;
  for (int i = 0; i < kCount; ++i) {
    NatsOptions options = options_of(server.port(), static_cast<PeerId>(i + 1));
    options.hub = hub;
    options.cells.near = 4.0;
    options.cells.slack = 0.4;
    peers.push_back(std::make_unique<NatsTransport>(options));
    peers.back()->set_position(Vec3(2.0 * i, 0.0, 0.0));  // a row, of which two on each side hear
  }
  const auto links = [&](int i) {
    int count = 0;
    for (const PeerStatus& each : peers[static_cast<std::size_t>(i)]->peers()) {
      count += each.connected ? 1 : 0;
    }
    return count;
  };
  REQUIRE(eventually([&] {
    for (int i = 2; i < kCount - 2; ++i) {
      if (links(i) != 4) return false;
    }
    return true;
  }));
  CHECK(links(0) == 2);
  CHECK(peers[10]->status().cells > 0);
}

TEST_CASE("nats: options are refused by name, value and rule", "[nats][fault]") {
  NatsOptions options = options_of(4222, 1);
  options.prefix = "a.b";
  CHECK(names(refusal([&] { options.validate(); }), "prefix", "a.b", "letters"));
  options = options_of(4222, 1);
  options.cells.near = -1.0;
  CHECK(names(refusal([&] { options.validate(); }), "near", "-1", "edges"));
  options = options_of(4222, 0);
  CHECK(names(refusal([&] { options.validate(); }), "self", "0", "not 0"));
  options = options_of(4222, 1);
  options.cells.summary_hz = 60.0;
  CHECK(names(refusal([&] { options.validate(); }), "summary_hz", "60", "5"));
  options = options_of(4222, 1);
  options.server.reconnect_wait = std::chrono::milliseconds(1);
  CHECK(names(refusal([&] { NatsTransport{options}; }), "reconnect_wait", "1", "10 ms"));
  options = options_of(4222, 1);
  options.server.servers.clear();
  CHECK(names(refusal([&] { NatsTransport{options}; }), "servers", "empty", "at least one"));
}

}  // namespace
}  // namespace tandem::nats::transport_test
