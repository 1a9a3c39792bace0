// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/tcp.h"

#include <memory>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "raw_peer.h"
#include "support/catch.h"
#include "support/free_port.h"

namespace tcp_test {

using namespace tandem::net;
using raw::connected;
using raw::eventually;
using raw::linked;
using raw::options;
using raw::status;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::testing::free_port;

namespace {

raw::Bytes random_bytes(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  raw::Bytes out(size);
  for (std::byte& b : out) b = static_cast<std::byte>(random());
  return out;
}

}  // namespace

TEST_CASE("tcp: two peers meet, and nothing is left after them", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  TcpTransport b(options(2, {a.local_port()}));
  CHECK(a.self() == 1);
  CHECK(a.local_port() != 0);
  CHECK_FALSE(a.post(7, random_bytes(3, 1), Delivery::Reliable));  // unknown
  REQUIRE(eventually([&] { return linked(a, b); }));
  CHECK(status(a, 2).reason.empty());
  CHECK(a.incarnation(2) != 0);
  CHECK(a.incarnation(7) == 0);
  REQUIRE(b.dials().size() == 1);
  CHECK(eventually([&] { return b.dials()[0].peer == 1 && b.dials()[0].connected; }));
}

TEST_CASE("tcp: frames arrive whole and in order, up to the longest", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  TcpTransport b(options(2, {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  const std::vector<std::size_t> sizes = {0, 1, 100, 65536, 65535, 4096, 0, 65536, 17};
  std::uint64_t total = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const auto delivery = i % 2 == 0 ? Delivery::Newest : Delivery::Reliable;
    REQUIRE(b.post(1, random_bytes(sizes[i], i), delivery));
    total += sizes[i];
  }
  CHECK_FALSE(b.post(1, random_bytes(65537, 0), Delivery::Reliable));
  const std::vector<Packet> got = raw::receive(a, sizes.size());
  REQUIRE(got.size() == sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    CHECK(got[i].from == 2);
    CHECK(got[i].bytes == random_bytes(sizes[i], i));
  }
  CHECK(status(a, 2).packets_in == sizes.size());
  CHECK(status(a, 2).bytes_in == total);
  CHECK(status(b, 1).packets_out == sizes.size());
  CHECK(status(b, 1).bytes_out == total);
  CHECK(status(b, 1).dropped_queue_full == 0);
  CHECK(connected(b, 1));
}

TEST_CASE("tcp: many frames both ways at once stay in order", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  TcpTransport b(options(2, {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  constexpr std::uint64_t kCount = 3000;
  std::vector<Packet> at_a, at_b;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    REQUIRE(a.post(2, raw::le(i, 8), Delivery::Reliable));
    REQUIRE(b.post(1, raw::le(i, 8), Delivery::Reliable));
    a.drain(at_a);
    b.drain(at_b);
  }
  CHECK(eventually([&] {
    a.drain(at_a);
    b.drain(at_b);
    return at_a.size() >= kCount && at_b.size() >= kCount;
  }));
  for (const auto* got : {&at_a, &at_b}) {
    REQUIRE(got->size() == kCount);
    for (std::uint64_t i = 0; i < kCount; ++i) REQUIRE(raw::number((*got)[i].bytes) == i);
  }
}

TEST_CASE("tcp: one address is enough for a full mesh", "[net][socket]") {
  const raw::LeakCheck leaks;
  // Every order of ids: who dials whom depends on it.
  for (const auto& ids :
       std::vector<std::vector<PeerId>>{{1, 2, 3, 4}, {4, 3, 2, 1}, {2, 4, 1, 3}}) {
    std::vector<std::unique_ptr<TcpTransport>> all;
    all.push_back(std::make_unique<TcpTransport>(options(ids[0])));
    const std::uint16_t first = all[0]->local_port();
    for (std::size_t i = 1; i < ids.size(); ++i) {
      all.push_back(std::make_unique<TcpTransport>(options(ids[i], {first})));
    }
    for (const auto& a : all) {
      for (const auto& b : all) {
        if (a == b) continue;
        REQUIRE(eventually([&] { return linked(*a, *b); }));
        REQUIRE(eventually(
            [&] { return a->post(b->self(), raw::le(a->self(), 8), Delivery::Reliable); }));
      }
    }
    for (const auto& a : all) {
      std::vector<Packet> got = raw::receive(*a, ids.size() - 1);
      CHECK(got.size() == ids.size() - 1);
      for (const Packet& packet : got) CHECK(raw::number(packet.bytes) == packet.from);
    }
  }
}

TEST_CASE("tcp: a peer that only dials is part of the mesh", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport hub(options(1));
  auto silent = options(2, {hub.local_port()});  // the lower id, which would let the other one dial
  silent.listen_port.reset();
  TcpTransport dialler(silent);
  CHECK(dialler.local_port() == 0);
  REQUIRE(eventually([&] { return linked(hub, dialler); }));
  TcpTransport newcomer(options(3, {hub.local_port()}));
  CHECK(eventually([&] { return linked(newcomer, dialler) && linked(newcomer, hub); }));
}

TEST_CASE("tcp: IPv4 and IPv6 peers form one mesh", "[net][socket]") {
  const raw::LeakCheck leaks;
  auto both = options(1);
  both.listen_address = "::";
  both.insecure = true;
  std::unique_ptr<TcpTransport> a;
  try {
    a = std::make_unique<TcpTransport>(both);
  } catch (const std::system_error& error) {
    WARN(std::string("no IPv6 here: ") + error.what());
    return;
  }
  auto by_v6 = options(2);
  by_v6.listen_address = "::";
  by_v6.insecure = true;
  by_v6.connect = {{"::1", a->local_port()}};
  TcpTransport b(by_v6);
  REQUIRE(eventually([&] { return linked(*a, b); }));
  TcpTransport c(options(3, {a->local_port()}));  // comes as an IPv4 address in an IPv6 one
  CHECK(eventually([&] { return linked(*a, c) && linked(b, c); }));
  CHECK(c.dials()[0].address.host == "127.0.0.1");
}

TEST_CASE("tcp: peers that dial each other keep one connection", "[net][socket]") {
  const raw::LeakCheck leaks;
  const auto descriptors = [] { return raw::LeakCheck::count("/proc/self/fd"); };
  const auto unconnected = [&] {  // two transports that listen
    const TcpTransport x(options(8)), y(options(9));
    return descriptors();
  }();
  for (int round = 0; round < 20; ++round) {
    // Both dial what they are given.
    const std::uint16_t port_a = free_port();
    TcpTransport b(options(2, {port_a}));
    auto for_a = options(1, {b.local_port()});
    for_a.listen_port = port_a;
    for_a.connect.push_back({"localhost", b.local_port()});  // and the same by another name
    TcpTransport a(for_a);
    REQUIRE(eventually([&] { return linked(a, b); }));
    // And the two ends of one connection.
    const int ends = raw::LeakCheck::kCounts ? 2 : 0;
    CHECK(eventually([&] { return linked(a, b) && descriptors() == unconnected + ends; }));
    REQUIRE(eventually([&] { return a.post(2, raw::le(5, 8), Delivery::Reliable); }));
    REQUIRE(eventually([&] { return b.post(1, raw::le(6, 8), Delivery::Reliable); }));
    CHECK(raw::receive(b, 1).size() == 1);
    CHECK(raw::receive(a, 1).size() == 1);
  }
}

TEST_CASE("tcp: different scenes are refused with the reason on both sides", "[net][socket]") {
  const raw::LeakCheck leaks;
  auto for_a = options(1);
  for_a.scene_hash = 0xabc;
  TcpTransport a(for_a);
  auto for_b = options(2, {a.local_port()});
  for_b.scene_hash = 0xdef;
  TcpTransport b(for_b);
  CHECK(eventually([&] {
    return status(a, 2).reason.find(
               "scene hash 0x0000000000000def differs from 0x0000000000000abc") !=
           std::string::npos;
  }));
  CHECK(eventually([&] {
    return status(b, 1).reason.find(
               "scene hash 0x0000000000000abc differs from 0x0000000000000def") !=
           std::string::npos;
  }));
  CHECK(status(a, 2).rejected > 0);
  CHECK(status(b, 1).rejected > 0);
  CHECK(a.strangers().refused > 0);
  CHECK_FALSE(connected(a, 2));
  CHECK_FALSE(connected(b, 1));
}

TEST_CASE("tcp: a peer that dials itself finds out", "[net][socket]") {
  const raw::LeakCheck leaks;
  const std::uint16_t port = free_port();
  auto own = options(1, {port});
  own.listen_port = port;
  TcpTransport a(own);
  CHECK(eventually(
      [&] { return a.dials()[0].reason.find("used by both ends") != std::string::npos; }));
  CHECK(a.dials()[0].attempts == 1);
  CHECK(a.peers().empty());
}

TEST_CASE("tcp: an address where nobody listens is dialled on and on", "[net][socket]") {
  const raw::LeakCheck leaks;
  const std::uint16_t port = free_port();
  TcpTransport b(options(2, {port}));
  CHECK(eventually([&] { return b.dials()[0].attempts >= 3; }));
  CHECK(b.dials()[0].reason.find("cannot connect") != std::string::npos);
  auto for_a = options(1);
  for_a.listen_port = port;
  TcpTransport a(for_a);
  CHECK(eventually([&] { return linked(a, b); }));
}

TEST_CASE("tcp: a port in use is an error with a clear text", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  auto same = options(2);
  same.listen_port = a.local_port();
  try {
    const TcpTransport refused(same);
    FAIL("two listen on one port");
  } catch (const std::system_error& error) {
    CHECK(error.code() == std::errc::address_in_use);
  }
  CHECK_THROWS_WITH(TcpTransport(same), Catch::Matchers::Contains("cannot listen on 127.0.0.1:" +
                                                                  std::to_string(a.local_port())));
  CHECK_THROWS_AS(TcpTransport(options(0)), std::invalid_argument);
}

TEST_CASE("tcp: options that cannot work are refused by name", "[net][fault]") {
  using std::chrono::milliseconds;
  const auto refused = [](const std::string& field, auto change) {
    TcpOptions broken = options(1);
    change(broken);
    CHECK_THROWS_WITH(TcpTransport(broken),
                      Catch::Matchers::Contains("TcpOptions: " + field + " must be "));
  };
  refused("self", [](TcpOptions& o) { o.self = 0; });
  refused("listen_address", [](TcpOptions& o) { o.listen_address.clear(); });
  refused("connect", [](TcpOptions& o) { o.connect = {{"host", 0}}; });
  refused("max_message_bytes", [](TcpOptions& o) { o.max_message_bytes = 63; });
  refused("max_message_bytes", [](TcpOptions& o) { o.max_message_bytes = 1u << 25; });
  refused("send_queue_bytes", [](TcpOptions& o) { o.send_queue_bytes = 131071; });
  refused("receive_queue_bytes", [](TcpOptions& o) { o.receive_queue_bytes = 131071; });
  refused("max_peers", [](TcpOptions& o) { o.max_peers = 0; });
  refused("socket_buffer_bytes", [](TcpOptions& o) { o.socket_buffer_bytes = 0; });
  refused("handshake_timeout", [](TcpOptions& o) { o.handshake_timeout = milliseconds(0); });
  refused("idle_timeout", [](TcpOptions& o) { o.idle_timeout = milliseconds(0); });
  refused("backoff_min", [](TcpOptions& o) { o.backoff_min = milliseconds(0); });
  refused("backoff_max", [](TcpOptions& o) { o.backoff_max = milliseconds(9); });
  refused("drop_hold", [](TcpOptions& o) { o.drop_hold = milliseconds(-1); });
  refused("flush_timeout", [](TcpOptions& o) { o.flush_timeout = milliseconds(10001); });
}

}  // namespace tcp_test
