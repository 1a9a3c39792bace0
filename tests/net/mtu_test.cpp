// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// How long datagrams may be is found out, on ways that drop what is too long and say nothing.
#include <algorithm>

#include "sim_link.h"
#include "sim_world.h"
#include "support/catch.h"

namespace mtu_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::PeerId;

namespace {

/// States as long as is allowed, and short messages, one of each every 16 ms.
struct Traffic {
  explicit Traffic(Pair& on) : pair(on) {
    pair.each_step = [this] {
      if (pair.now % (16 * kMs) == 0) {
        const std::size_t longest =
            pair.a.channels().mtu().size() - kProtectedOverhead - kChannelHeader - kStateHeader;
        CHECK(pair.a.post(Bytes(longest), Delivery::Newest, pair.now));
        CHECK(pair.a.post(Bytes(100), Delivery::Reliable, pair.now));
        ++posted;
      }
      std::vector<Channels::Message> messages;
      pair.b.channels().inbox().drain(messages);
      for (const auto& message : messages) {
        (message.delivery == Delivery::Newest ? states : reliable) += 1;
      }
    };
  }
  Pair& pair;
  std::uint64_t posted = 0;
  std::uint64_t states = 0;
  std::uint64_t reliable = 0;
};

UdpConnectionOptions fast() {
  UdpConnectionOptions options;
  options.congestion.max_kbit = 4000.0;
  return options;
}

}  // namespace

TEST_CASE("mtu: the path's limit is found to 16 bytes, also under loss", "[net]") {
  const std::size_t mtu = GENERATE(548u, 700u, 1199u, 1200u, 1300u, 1452u, 1471u, 1472u, 9000u);
  const double loss = GENERATE(0.0, 0.1);
  Pair pair({.delay = 20 * kMs, .loss = loss, .mtu = mtu}, fast());
  Traffic traffic(pair);
  pair.run(10 * kSecond);
  const std::size_t found = pair.a.channels().mtu().size();
  const std::size_t best = std::min(mtu, kMaxDatagram);
  CAPTURE(mtu, loss, found);
  CHECK(found <= best);
  CHECK(found + MtuSearch::kFine > best);
  // Probes that are lost do not take the rate: they are not congestion.
  if (loss == 0.0 && mtu >= MtuSearch::kBase) CHECK(pair.a.congestion().rate() == 4000.0);
  CHECK(pair.a.state() == UdpConnection::State::Open);
}

TEST_CASE("mtu: a way that becomes narrower is noticed, and one that becomes wider used",
          "[net][fault]") {
  Pair pair({.delay = 20 * kMs}, fast());
  Traffic traffic(pair);
  pair.run(3 * kSecond);
  REQUIRE(pair.a.channels().mtu().size() == kMaxDatagram);
  for (const std::size_t mtu : {std::size_t{1300}, std::size_t{600}}) {
    pair.there.set({.delay = 20 * kMs, .mtu = mtu});
    pair.run(kSecond);
    CHECK(pair.a.channels().mtu().size() <= mtu);
    pair.run(9 * kSecond);
    CHECK(pair.a.channels().mtu().size() + MtuSearch::kFine > mtu);
    const std::uint64_t states = traffic.states;
    const std::uint64_t posted = traffic.posted;
    pair.run(2 * kSecond);
    CHECK(traffic.states - states >= traffic.posted - posted - 3);
  }
  pair.there.set({.delay = 20 * kMs});
  pair.run(11 * 60 * kSecond);
  CHECK(pair.a.channels().mtu().size() == kMaxDatagram);
  CHECK(traffic.reliable + 5 >= traffic.posted);
}

TEST_CASE("mtu: loss that has nothing to do with length takes nothing for long", "[net][fault]") {
  const double loss = GENERATE(0.3, 0.5);
  Pair pair({.delay = 20 * kMs, .loss = loss}, fast());
  Traffic traffic(pair);
  std::uint64_t narrow = 0;
  std::uint64_t steps = 0;
  const auto post = pair.each_step;
  pair.each_step = [&] {
    post();
    narrow += pair.a.channels().mtu().size() < MtuSearch::kBase ? 1 : 0;
    ++steps;
  };
  pair.run(60 * kSecond);
  INFO(loss << ": narrow in " << narrow << " of " << steps << " ms");
  CHECK(narrow < steps / 50);
  CHECK(pair.a.channels().mtu().size() >= MtuSearch::kBase);
}

TEST_CASE("mtu: an outage says nothing of lengths", "[net][fault]") {
  Pair pair({.delay = 20 * kMs}, fast());
  Traffic traffic(pair);
  pair.run(3 * kSecond);
  pair.there.set({.delay = 20 * kMs, .loss = 1.1});
  pair.back.set({.delay = 20 * kMs, .loss = 1.1});
  pair.run(2 * kSecond);
  pair.there.set({.delay = 20 * kMs});
  pair.back.set({.delay = 20 * kMs});
  pair.run(kSecond);
  CHECK(pair.a.channels().mtu().size() == kMaxDatagram);
}

TEST_CASE("mtu: a peer is given states as long as all ways carry", "[net]") {
  World world({.delay = 20 * kMs});
  for (PeerId peer = 1; peer <= 3; ++peer) {
    UdpNode& node = world.start(peer);
    if (peer > 1) node.dial(address_of(1), 0);
  }
  CHECK(world.node(1).max_state_bytes() == 1154);
  world.path(address_of(1), address_of(2)).set({.delay = 20 * kMs, .mtu = 1300});
  world.each_step = [&] {
    if (world.now % (16 * kMs) != 0) return;
    for (PeerId peer = 2; peer <= 3; ++peer) {
      (void)world.node(1).post(peer, Bytes(world.node(1).max_state_bytes()), Delivery::Newest,
                               world.now);
      (void)world.node(1).post(peer, Bytes(10), Delivery::Reliable, world.now);
    }
  };
  world.run(30 * kSecond);
  CHECK(world.node(1).max_state_bytes() > 1300 - 46 - MtuSearch::kFine);
  CHECK(world.node(1).max_state_bytes() <= 1300 - 46);
}

}  // namespace mtu_test
