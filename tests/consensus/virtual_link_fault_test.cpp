// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <limits>
#include <stdexcept>
#include <vector>

#include "consensus/network_fixture.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"

namespace virtual_link_fault_test {

using namespace tandem::consensus;
using namespace tandem::consensus::testing;

TEST_CASE("virtual_link: reliable packets all arrive, once and in order, over a bad link",
          "[consensus][fault]") {
  LinkOptions options;
  options.latency = 0.03;
  options.jitter = 0.02;
  options.loss = 0.3;
  options.duplicate = 0.3;
  options.reorder = 0.3;
  options.reorder_delay = 0.1;
  const int count = 5000;
  LinkCounters counters;
  const std::vector<Arrival> arrivals =
      run_stream(options, 17, count, 5 * kMs, Delivery::Reliable, &counters);
  REQUIRE(arrivals.size() == static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) CHECK(arrivals[static_cast<std::size_t>(i)].number == i);
  CHECK(counters.lost == 0);
  // Each packet needs 0.3 / 0.7 resends on average.
  CHECK(static_cast<double>(counters.resent) == Approx(count * 0.3 / 0.7).epsilon(0.1));
}

TEST_CASE("virtual_link: a lost reliable packet comes twice the latency later",
          "[consensus][analytic]") {
  LinkOptions options;
  options.latency = 0.03;
  options.loss = 0.4;
  // One packet per second: none waits for the one before. 30, 90, 150, ... ms.
  int late = 0;
  for (const Arrival& a : run_stream(options, 4, 500, 1000 * kMs, Delivery::Reliable)) {
    CHECK((a.delay - 30 * kMs) % (60 * kMs) == 0);
    if (a.delay > 30 * kMs) ++late;
  }
  CHECK(late > 150);
  CHECK(late < 250);
}

TEST_CASE("virtual_link: a cut link loses states, keeps reliable packets and tells both sides",
          "[consensus][fault]") {
  LinkOptions options;
  options.latency = 0.05;
  VirtualNetwork network(options, 1);
  Transport& a = network.transport(1);
  Transport& b = network.transport(2);
  a.post(2, numbered(1), Delivery::Newest);
  a.post(2, numbered(2), Delivery::Reliable);
  b.post(1, numbered(3), Delivery::Newest);
  network.advance_to(20 * kMs);
  network.cut(1, 2);
  CHECK_FALSE(a.peers()[0].connected);
  CHECK_FALSE(b.peers()[0].connected);
  CHECK(a.peers()[0].reason == "link cut");
  CHECK(b.peers()[0].reason == "link cut");
  CHECK_FALSE(a.post(2, numbered(4), Delivery::Newest));
  CHECK(a.post(2, numbered(5), Delivery::Reliable));

  network.advance_to(500 * kMs);
  std::vector<Packet> got;
  b.drain(got);
  CHECK(got.empty());
  a.drain(got);
  CHECK(got.size() == 1);  // the other direction was not cut
  CHECK(network.counters(1, 2).cut == 2);

  network.heal(1, 2);
  CHECK(a.peers()[0].connected);
  CHECK(a.peers()[0].reason.empty());
  a.post(2, numbered(6), Delivery::Newest);
  network.advance_to(550 * kMs);
  got.clear();
  b.drain(got);
  REQUIRE(got.size() == 3);
  CHECK(number_of(got[0].bytes) == 2);
  CHECK(number_of(got[1].bytes) == 5);
  CHECK(number_of(got[2].bytes) == 6);
}

TEST_CASE("virtual_link: a dropped peer is cut off with a reason until a new handshake",
          "[consensus][fault]") {
  LinkOptions options;
  options.latency = 0.05;
  VirtualNetwork network(options, 1);
  Transport& a = network.transport(1);
  Transport& b = network.transport(2);
  Transport& c = network.transport(3);
  b.post(1, numbered(1), Delivery::Reliable);
  network.advance_to(50 * kMs);  // 1 is in a's inbox when a loses patience, 2 on its way
  b.post(1, numbered(2), Delivery::Reliable);
  a.drop(2, "not a number");
  CHECK(a.peers()[0].reason == "not a number");
  CHECK_FALSE(a.peers()[0].connected);
  CHECK(b.peers()[0].reason == "dropped by the peer: not a number");
  CHECK_FALSE(b.post(1, numbered(3), Delivery::Reliable));
  CHECK_FALSE(a.post(2, numbered(3), Delivery::Newest));
  CHECK(b.post(3, numbered(4), Delivery::Newest));
  network.advance_to(1000 * kMs);
  std::vector<Packet> got;
  a.drain(got);
  CHECK(got.empty());
  c.drain(got);
  CHECK(got.size() == 1);

  network.heal(2, 1);
  network.heal(1, 2);
  CHECK(a.peers()[0].connected);
  CHECK(b.post(1, numbered(5), Delivery::Newest));
  network.advance_to(1050 * kMs);
  got.clear();
  a.drain(got);
  REQUIRE(got.size() == 1);
  CHECK(number_of(got[0].bytes) == 5);
  a.drop(99, "nobody");
}

TEST_CASE("virtual_link: invalid packets are refused at once", "[consensus][fault]") {
  VirtualNetwork network;
  Transport& a = network.transport(1);
  network.transport(2);
  CHECK_FALSE(a.post(9, numbered(0), Delivery::Reliable));
  CHECK_FALSE(a.post(1, numbered(0), Delivery::Reliable));
  CHECK_FALSE(a.post(2, numbered(0, VirtualNetwork::kMaxPacketBytes + 1), Delivery::Reliable));
  CHECK(a.post(2, numbered(0, VirtualNetwork::kMaxPacketBytes), Delivery::Reliable));
  CHECK(a.post(2, {}, Delivery::Newest));
}

TEST_CASE("virtual_link: reliable packets that wait are bounded", "[consensus][fault]") {
  VirtualNetwork network;
  Transport& a = network.transport(1);
  network.transport(2);
  network.cut(1, 2);
  int posted = 0;
  while (posted < 1000 && a.post(2, numbered(posted, 64 * 1024), Delivery::Reliable)) ++posted;
  CHECK(posted == 16);
}

TEST_CASE("virtual_link: bad arguments are refused by name", "[consensus][fault]") {
  VirtualNetwork network;
  network.transport(1);
  network.transport(2);
  CHECK_THROWS_AS(network.transport(0), std::invalid_argument);
  CHECK_THROWS_AS(network.cut(1, 3), std::invalid_argument);
  CHECK_THROWS_AS(network.heal(3, 1), std::invalid_argument);
  CHECK_THROWS_AS(network.counters(1, 1), std::invalid_argument);
  CHECK_THROWS_AS(network.set_link(2, 3, {}), std::invalid_argument);
  network.advance_to(5);
  CHECK_THROWS_AS(network.advance_to(4), std::invalid_argument);

  const auto refused = [](auto change, const char* field) {
    LinkOptions options;
    change(options);
    CHECK_THROWS_WITH(VirtualNetwork(options), Catch::Contains(field));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([](LinkOptions& o) { o.latency = -1e-3; }, "latency");
  refused([&](LinkOptions& o) { o.latency = nan; }, "latency");
  refused([](LinkOptions& o) { o.jitter = -1.0; }, "jitter");
  refused([](LinkOptions& o) { o.loss = 1.0; }, "loss");
  refused([&](LinkOptions& o) { o.loss = nan; }, "loss");
  refused([](LinkOptions& o) { o.duplicate = 1.1; }, "duplicate");
  refused([](LinkOptions& o) { o.reorder = -0.1; }, "reorder");
  refused([](LinkOptions& o) { o.reorder_delay = 1e9; }, "reorder_delay");
  refused([](LinkOptions& o) { o.bandwidth = -5.0; }, "bandwidth");
}

}  // namespace virtual_link_fault_test
