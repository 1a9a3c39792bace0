// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Peers that leave, die, come back, or are dropped.
#include <memory>
#include <string>
#include <vector>

#include "raw_peer.h"
#include "support/catch.h"
#include "support/free_port.h"
#include "tandem/net/tcp.h"

namespace tcp_restart_test {

using namespace tandem::net;
using raw::connected;
using raw::eventually;
using raw::linked;
using raw::options;
using raw::status;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::testing::free_port;

TEST_CASE("tcp: a peer that ends and starts again is met again", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  std::uint64_t incarnation = 0;
  for (int life = 0; life < 5; ++life) {
    TcpTransport b(options(2, {a.local_port()}));
    REQUIRE(eventually([&] { return linked(a, b); }));
    CHECK(a.incarnation(2) > incarnation);
    incarnation = a.incarnation(2);
    REQUIRE(a.post(2, raw::le(7, 8), Delivery::Reliable));
    CHECK(raw::receive(b, 1).size() == 1);
  }
  CHECK(eventually([&] { return !connected(a, 2); }));
  CHECK(status(a, 2).reason == "peer: has left");
  CHECK(a.peers().size() == 1);
}

TEST_CASE("tcp: the one that is dialled may restart as well", "[net][socket]") {
  const raw::LeakCheck leaks;
  auto again = options(1);
  again.listen_port = free_port();
  auto a = std::make_unique<TcpTransport>(again);
  TcpTransport b(options(2, {a->local_port()}));
  TcpTransport c(options(3, {a->local_port()}));
  for (int life = 0; life < 3; ++life) {
    REQUIRE(eventually([&] { return linked(*a, b) && linked(*a, c) && linked(b, c); }));
    a.reset();
    CHECK(eventually([&] { return !connected(b, 1) && !connected(c, 1); }));
    CHECK(linked(b, c));
    a = std::make_unique<TcpTransport>(again);
  }
  CHECK(eventually([&] { return linked(*a, b) && linked(*a, c); }));
}

TEST_CASE("tcp: a peer that moved to another port is met again", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  TcpTransport b(options(2, {a.local_port()}));
  for (int life = 0; life < 3; ++life) {
    TcpTransport c(options(3, {a.local_port()}));  // a port of its own each time
    CHECK(eventually([&] { return linked(a, c) && linked(b, c); }));
  }
}

TEST_CASE("tcp: a killed peer is noticed with a reason", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  raw::Socket peer = raw::Socket::connect(a.local_port());
  raw::join(peer, {.peer = 2});
  REQUIRE(eventually([&] { return connected(a, 2); }));
  peer.reset();
  CHECK(eventually([&] { return !connected(a, 2); }));
  CHECK(status(a, 2).reason.find("connection lost: ") == 0);
  CHECK_FALSE(a.post(2, raw::le(1, 8), Delivery::Reliable));
}

TEST_CASE("tcp: a peer that falls silent is cut", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpOptions watchful = options(1);
  watchful.idle_timeout = std::chrono::milliseconds(200);
  TcpTransport a(watchful);
  raw::Socket peer = raw::Socket::connect(a.local_port());
  raw::join(peer, {.peer = 2});
  CHECK(eventually([&] { return status(a, 2).reason.find("nothing heard") != std::string::npos; }));
}

TEST_CASE("tcp: a peer with nothing to say is kept", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpOptions watchful = options(1);
  watchful.idle_timeout = std::chrono::milliseconds(1000);
  TcpTransport a(watchful);
  raw::Socket peer = raw::Socket::connect(a.local_port());
  raw::join(peer, {.peer = 2, .idle_ms = 200});
  // It is pinged as often as it asked for, not as this end needs it.
  for (int i = 0; i < 10; ++i) {
    REQUIRE(peer.read(raw::kPing));
    REQUIRE(peer.send(raw::frame(raw::kPing, {})));
  }
  CHECK(connected(a, 2));
}

TEST_CASE("tcp: a restarted peer replaces the connection of its dead predecessor",
          "[net][socket]") {
  const raw::LeakCheck leaks;
  const PeerId self = GENERATE(as<PeerId>{}, 1, 9);  // deciding or not
  TcpTransport a(options(self));
  raw::Socket dead = raw::Socket::connect(a.local_port());
  raw::join(dead, {.peer = 2, .incarnation = 10});
  REQUIRE(eventually([&] { return connected(a, 2); }));
  REQUIRE(dead.send(raw::frame(raw::kNewest, raw::text("old"))));
  REQUIRE(eventually([&] { return status(a, 2).packets_in == 1; }));

  raw::Socket restarted = raw::Socket::connect(a.local_port());
  raw::join(restarted, {.peer = 2, .incarnation = 11});
  REQUIRE(eventually([&] { return a.incarnation(2) == 11; }));
  CHECK(connected(a, 2));
  const auto goodbye = dead.read(raw::kGoodbye);
  REQUIRE(goodbye);
  CHECK(raw::as_text(goodbye->payload) == "replaced by a newer connection");
  // Late packets of the predecessor are not taken.
  dead.send(raw::frame(raw::kNewest, raw::text("ghost")));
  REQUIRE(restarted.send(raw::frame(raw::kNewest, raw::text("new"))));
  const std::vector<Packet> got = raw::receive(a, 2);
  REQUIRE(got.size() == 2);
  CHECK(raw::as_text(got[0].bytes) == "old");
  CHECK(raw::as_text(got[1].bytes) == "new");

  SECTION("the predecessor does not get back in") {
    raw::Socket back = raw::Socket::connect(a.local_port());
    REQUIRE(back.send(raw::hello({.peer = 2, .incarnation = 10})));
    const auto refusal = back.read(raw::kGoodbye);
    REQUIRE(refusal);
    CHECK(raw::as_text(refusal->payload) == "a newer process has taken peer id 2");
    CHECK(connected(a, 2));
    CHECK(a.incarnation(2) == 11);
  }
}

TEST_CASE("tcp: the same process may replace its half-dead connection", "[net][socket]") {
  const raw::LeakCheck leaks;
  const PeerId self = GENERATE(as<PeerId>{}, 1, 9);
  TcpTransport a(options(self));
  raw::Socket half_dead = raw::Socket::connect(a.local_port());
  raw::join(half_dead, {.peer = 2}, 0, 1);
  REQUIRE(eventually([&] { return connected(a, 2); }));
  raw::Socket fresh = raw::Socket::connect(a.local_port());
  raw::join(fresh, {.peer = 2}, 0, 2);
  REQUIRE(half_dead.read(raw::kGoodbye));
  CHECK(connected(a, 2));
  REQUIRE(a.post(2, raw::text("hi"), Delivery::Newest));
  CHECK(fresh.read(raw::kNewest));
}

TEST_CASE("tcp: of two connections the later welcome of the lower id counts", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(9));
  raw::Socket one = raw::Socket::connect(a.local_port());
  raw::Socket two = raw::Socket::connect(a.local_port());
  REQUIRE(one.send(raw::hello({.peer = 2})));
  REQUIRE(two.send(raw::hello({.peer = 2})));
  REQUIRE(one.read(raw::kHello));
  REQUIRE(two.read(raw::kHello));
  // They arrive the other way round.
  REQUIRE(two.send(raw::welcome(2, 0)));
  REQUIRE(two.read(raw::kWelcome));
  REQUIRE(one.send(raw::welcome(1, 0)));
  const auto goodbye = one.read();
  REQUIRE(goodbye);
  CHECK(goodbye->type == raw::kGoodbye);
  REQUIRE(a.post(2, raw::text("hi"), Delivery::Newest));
  CHECK(two.read(raw::kNewest));
}

TEST_CASE("tcp: a dropped peer is out at once and comes back by a new handshake", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpOptions strict = options(1);
  strict.drop_hold = std::chrono::milliseconds(100);
  TcpTransport a(strict);
  TcpTransport b(options(2, {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  REQUIRE(b.post(1, raw::text("bad"), Delivery::Newest));
  REQUIRE(eventually([&] { return status(a, 2).packets_in == 1; }));
  a.drop(2, "sends nonsense");
  CHECK_FALSE(connected(a, 2));
  CHECK(status(a, 2).reason == "dropped: sends nonsense");
  CHECK_FALSE(a.post(2, raw::text("x"), Delivery::Reliable));
  std::vector<Packet> got;
  a.drain(got);
  CHECK(got.empty());
  CHECK(eventually([&] { return status(b, 1).reason.find("peer: dropped: sends nonsense") == 0; }));
  CHECK(eventually([&] { return linked(a, b); }));
  CHECK(status(a, 2).reason.empty());
}

TEST_CASE("tcp: a dropped peer is not dialled", "[net][socket]") {
  const raw::LeakCheck leaks;
  raw::Listener there;
  TcpTransport a(options(1, {there.port()}));
  const auto accept = [&] {
    raw::Socket peer = there.accept();
    const auto hello = peer.read(raw::kHello);
    REQUIRE(hello);
    REQUIRE(peer.send(raw::hello({.peer = 2})));
    const auto welcome = peer.read(raw::kWelcome);
    REQUIRE(welcome);
    REQUIRE(peer.send(raw::welcome(raw::number(std::span(welcome->payload).first(8)), 0)));
    REQUIRE(eventually([&] { return connected(a, 2); }));
    return peer;
  };
  accept().reset();
  raw::Socket peer = accept();  // a lost one is dialled
  a.drop(2, "enough");
  REQUIRE(peer.read(raw::kGoodbye));
  peer.close();
  // Many times the longest back-off, 100 ms; on a slow machine this can only pass wrongly.
  CHECK_FALSE(there.readable(500));
}

}  // namespace tcp_restart_test
