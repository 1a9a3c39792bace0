// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Nodes that find each other by what members tell, and go through one another.
#include <vector>

#include "sim_world.h"
#include "support/catch.h"

namespace udp_mesh_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;

namespace {

/// Peers with known public keys: nobody can impersonate them, on any path.
void list_all(UdpNodeOptions& options) {
  for (PeerId peer = 1; peer <= 9; ++peer) {
    options.handshake.trusted[peer] = identity_of(peer).public_key;
  }
}

/// 1 and 3 know 2, and do not reach each other.
void start_three(World& world) {
  for (PeerId peer = 1; peer <= 3; ++peer) world.start(peer);
  world.node(1).dial(address_of(2), 0);
  world.node(3).dial(address_of(2), 0);
  cut(world, 1, 3);
}

/// Until 2 carries what they say to each other.
void begin_relayed(World& world) {
  world.change = list_all;
  start_three(world);
  world.run(6 * kSecond);
  REQUIRE(linked(world, 1, 3));
}

}  // namespace

TEST_CASE("udp node: a newcomer that knows one address meets all", "[net]") {
  World world({.delay = 20 * kMs, .loss = 0.1});
  world.start(1);
  for (PeerId peer = 2; peer <= 8; ++peer) world.start(peer).dial(address_of(peer - 1), 0);
  world.run(10 * kSecond);
  for (PeerId a = 1; a <= 8; ++a) {
    for (PeerId b = 1; b < a; ++b) CHECK(linked(world, a, b));
    CHECK(world.node(a).relay().counters().forwarded == 0);
  }
  world.start(9).dial(address_of(4), world.now);
  world.run(3 * kSecond);
  for (PeerId a = 1; a <= 8; ++a) CHECK(linked(world, a, 9));
}

TEST_CASE("udp node: peers without a route go through one that has it, and straight where they can",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  begin_relayed(world);
  CHECK(world.node(1).relay().relay_of(3) == 2);
  CHECK(world.node(3).relay().relay_of(1) == 2);
  CHECK(world.node(1).relay().relay_of(2) == 0);

  std::uint64_t next = 0;
  const auto exchange = [&](int count) {
    for (int i = 0; i < count; ++i) {
      REQUIRE(world.node(1).post(3, Bytes(1154, std::byte{5}), Delivery::Newest, world.now));
      REQUIRE(world.node(1).post(3, number(i), Delivery::Reliable, world.now));
      world.run(100 * kMs);
    }
    std::vector<Packet> packets;
    world.node(3).drain(packets);
    std::size_t states = 0;
    next = 0;
    for (const Packet& packet : packets) {
      if (packet.bytes.size() == 1154) ++states;
      if (packet.bytes.size() == 8) CHECK(tandem::pbd::ByteReader(packet.bytes).u64() == next++);
    }
    return states;
  };
  CHECK(exchange(20) >= 19);
  CHECK(next >= 19);
  CHECK(status(world.node(1), 3).round_trip > 79 * kMs);
  const std::uint64_t forwarded = world.node(2).relay().counters().forwarded;
  CHECK(forwarded > 40);

  // A second relay, and the first one goes: the connection stays.
  world.start(4).dial(address_of(2), world.now);
  world.run(4 * kSecond);
  world.stop(2);
  world.run(6 * kSecond);
  REQUIRE(linked(world, 1, 3));
  CHECK(world.node(1).relay().relay_of(3) == 4);
  exchange(5);

  // The way is open again: straight from then on, and no message is lost on the way over.
  cut(world, 1, 3, true);
  world.run(12 * kSecond);
  REQUIRE(linked(world, 1, 3));
  CHECK(world.node(1).relay().relay_of(3) == 0);
  const std::uint64_t at_the_end = world.node(4).relay().counters().forwarded;
  exchange(5);
  CHECK(next == 5);
  CHECK(world.node(4).relay().counters().forwarded == at_the_end);
}

TEST_CASE("udp node: a relay that alters, repeats or invents is heard by nobody", "[net][fault]") {
  World world({.delay = 10 * kMs});
  begin_relayed(world);
  // A possible attack by peer 2: hand over forged packets as "from 1".
  Dice dice(4);
  std::uint64_t posted = 0;
  std::uint64_t got = 0;
  world.each_step = [&] {
    if (world.now % (50 * kMs) == 0) {
      posted += world.node(1).post(3, number(posted), Delivery::Newest, world.now) ? 1 : 0;
    }
    for (int i = 0; i < 5; ++i) {
      Bytes junk = random_bytes(dice, 1 + dice.below(300));
      if (dice.chance(0.5)) junk[0] = std::byte{0x40};
      if (dice.chance(0.2)) junk[0] = std::byte{0x50};
      world.node(3).passed_on(2, {.peer = dice.chance(0.8) ? 1 : dice.below(50), .datagram = junk},
                              world.now);
    }
    std::vector<Packet> packets;
    world.node(3).drain(packets);
    for (const Packet& packet : packets) {
      if (packet.from == 1) CHECK(tandem::pbd::ByteReader(packet.bytes).u64() == got++);
    }
  };
  world.run(2 * kSecond);
  CHECK(got >= posted - 3);
  CHECK(status(world.node(3), 1).rejected == 0);
}

TEST_CASE("udp node: no relay where any of the three was told not to", "[net]") {
  const PeerId refuses = GENERATE(PeerId{1}, PeerId{2}, PeerId{3});
  World world({.delay = 10 * kMs});
  world.change = [refuses](UdpNodeOptions& options) {
    list_all(options);
    options.relay = options.handshake.self != refuses;
  };
  start_three(world);
  world.run(8 * kSecond);
  CHECK_FALSE(linked(world, 1, 3));
  CHECK(linked(world, 1, 2));
  // If 1 or 3 refuses, packets that peer 2 passes on are not answered: they never link.
  if (refuses == 2) CHECK(world.node(2).relay().counters().forwarded == 0);
}

TEST_CASE("udp node: a relay passes on within its budget only", "[net][fault]") {
  World world({.delay = 10 * kMs});
  begin_relayed(world);
  const std::uint64_t before = world.path(address_of(2), address_of(3)).bytes();
  for (int i = 0; i < 100; ++i) {  // 1.5 Mbit/s, where 256 kbit/s are allowed
    for (int k = 0; k < 10; ++k) {
      (void)world.node(1).post(3, Bytes(1000), Delivery::Newest, world.now);
    }
    world.run(50 * kMs);
  }
  const auto kbit =
      8e-3 * static_cast<double>(world.path(address_of(2), address_of(3)).bytes() - before) / 5.0;
  CHECK(kbit < 300.0);  // and 2's own
  CHECK(kbit > 100.0);
}

TEST_CASE("udp node: a member that tells nonsense of third peers costs a few small datagrams",
          "[net][fault]") {
  World world({.delay = 10 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  // As if 2 said so: a hundred peers at a hundred addresses, and what no host has.
  std::size_t sent = 0;
  world.tap = [&](const Bytes& datagram) { sent += datagram.size() == kHelloBytes ? 1 : 0; };
  for (int i = 0; i < 50; ++i) {
    for (PeerId peer = 50; peer < 150; ++peer) {
      world.node(1).told(2, {.peer = peer, .address = address_of(peer)}, world.now);
    }
    world.node(1).told(2, {.peer = 7, .address = {}}, world.now);
    world.node(1).told(2, {.peer = 1, .address = address_of(9)}, world.now);
    world.run(100 * kMs);
  }
  CHECK(sent > 10);
  CHECK(sent < 200);  // 16 addresses at a time, 8 questions in 5 s each
  CHECK(linked(world, 1, 2));
}

}  // namespace udp_mesh_test
