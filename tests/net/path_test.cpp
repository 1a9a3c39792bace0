// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Peers whose address changes in the middle of a session, and those who pretend it of others.
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <utility>

#include "sim_world.h"
#include "support/catch.h"
#include "tandem/pbd/bytes.h"

namespace path_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;

namespace {

/// An address outside the session at the start.
Address elsewhere(std::uint8_t host) {
  Address out = address_of(host);
  out.ip[12] = 192;
  return out;
}

/// 1 and 2 send to each other: a numbered message each 16 ms, and as many states.
class Talk {
 public:
  explicit Talk(World& world) : world_(world) {}

  void step() {
    for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
      UdpNode& node = world_.node(peer);
      if (world_.now % (16 * kMs) == 0 && world_.now < end) {
        posted_[peer] += node.post(3 - peer, number(posted_[peer]), Delivery::Reliable, world_.now);
        (void)node.post(3 - peer, Bytes(200), Delivery::Newest, world_.now);
      }
      std::vector<Packet> packets;
      node.drain(packets);
      for (const Packet& packet : packets) {
        if (packet.bytes.size() == 200) {
          gap_ = std::max(gap_, world_.now - last_[peer]);
          last_[peer] = world_.now;
        } else {
          in_order_ &= tandem::pbd::ByteReader(packet.bytes).u64() == got_[peer]++;
        }
      }
    }
  }
  bool is_complete() const {
    return in_order_ && got_.at(1) == posted_.at(2) && got_.at(2) == posted_.at(1);
  }
  /// The longest time that either has heard no state since then.
  void forget_gap() {
    gap_ = 0;
    last_[1] = last_[2] = world_.now;
  }
  std::int64_t gap() const { return gap_; }
  std::uint64_t posted() const { return posted_.at(1); }

  std::int64_t end = INT64_MAX;

 private:
  World& world_;
  std::map<PeerId, std::uint64_t> posted_{{1, 0}, {2, 0}};
  std::map<PeerId, std::uint64_t> got_{{1, 0}, {2, 0}};
  std::map<PeerId, std::int64_t> last_;
  std::int64_t gap_ = 0;
  bool in_order_ = true;
};

}  // namespace

TEST_CASE("path: a peer that changes its address keeps its connection and loses nothing",
          "[net][fault]") {
  const double loss = GENERATE(0.0, 0.1);
  World world({.delay = 20 * kMs, .jitter = 5 * kMs, .loss = loss});
  world.start(1);
  world.start(3).dial(address_of(1), 0);
  world.start(2).dial(address_of(1), 0);
  Talk talk(world);
  world.run(2 * kSecond);
  REQUIRE(linked(world, 1, 2));
  REQUIRE(linked(world, 2, 3));
  world.each_step = [&] { talk.step(); };
  talk.forget_gap();
  world.run(2 * kSecond);
  const auto strangers =
      world.node(1).strangers().challenged + world.node(2).strangers().challenged;
  // Four times: also back to where it was, and to another port of the same host.
  Address port = elsewhere(2);
  ++port.port;
  for (const Address& to : {elsewhere(2), port, address_of(2), elsewhere(9)}) {
    talk.forget_gap();
    world.move(2, to);
    world.run(3 * kSecond);
    CHECK(world.node(1).connections() == 2);
    CHECK(linked(world, 1, 2));
    CHECK(linked(world, 3, 2));
    // Half a round trip until it is heard, 0.1 s until no original comes, half a one back; with
    // loss the question goes again after 0.1 s, 0.2 s, ..
    INFO("ms without a state " << talk.gap() / kMs);
    CHECK(talk.gap() < (loss == 0.0 ? 250 : 800) * kMs);
  }
  CHECK(world.node(1).moves() == 4);
  CHECK(world.node(3).moves() == 4);
  CHECK(world.node(2).moves() == 0);
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
  CHECK(talk.posted() > 600);
  // No handshake was made for it.
  CHECK(world.node(1).strangers().challenged + world.node(2).strangers().challenged == strangers);
  // Later peers are told where it is now.
  world.start(4).dial(address_of(1), world.now);
  world.run(2 * kSecond);
  CHECK(linked(world, 4, 2));
  CHECK(world.node(4).relay().relay_of(2) == 0);
}

TEST_CASE("path: a connection that is silent moves with its next packet", "[net]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  world.move(2, elsewhere(2));
  world.run(2 * kSecond);  // a quarter of idle_timeout until something leaves
  CHECK(world.node(1).moves() == 1);
  world.run(6 * kSecond);
  CHECK(linked(world, 1, 2));
  CHECK(world.node(1).connections() == 1);
}

TEST_CASE("path: copies of packets from other addresses steal nothing and are answered with little",
          "[net][fault]") {
  // The attacker hears all and is faster than the way.
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  Talk talk(world);
  talk.forget_gap();
  Dice dice(3);
  std::map<std::uint8_t, std::uint64_t> sent;
  std::vector<Bytes> copies;
  world.tap = [&](const Bytes& datagram) { copies.push_back(datagram); };
  world.each_step = [&] {
    talk.step();
    const auto heard = std::exchange(copies, {});
    for (const Bytes& datagram : heard) {
      if (!dice.chance(0.5)) continue;
      const auto host = static_cast<std::uint8_t>(20 + dice.below(50));
      sent[host] += datagram.size() + kIpUdpBytes;
      for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
        world.node(peer).on_datagram(datagram, elsewhere(host), world.now);
      }
    }
  };
  world.run(10 * kSecond);
  world.tap = [](const Bytes&) {};
  talk.end = world.now;
  world.run(kSecond);
  CHECK(talk.is_complete());
  CHECK(talk.gap() < 60 * kMs);
  CHECK(world.node(1).moves() == 0);
  CHECK(world.node(2).moves() == 0);
  CHECK(world.node(1).connections() == 1);
  std::uint64_t answered = 0;
  for (const auto& [host, bytes] : sent) {
    for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
      const std::uint64_t back = world.path(address_of(peer), elsewhere(host)).bytes();
      CHECK(back <= 3 * bytes);
      answered += back;
    }
  }
  CHECK(answered > 0);
}

TEST_CASE("path: a thief that forwards faster than the network becomes no path", "[net][fault]") {
  // It hears all at once, and forwards to both ends, what is asked of its address included.
  World world({.delay = 50 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  const Address thief = elsewhere(66);
  world.watch(thief);
  Talk talk(world);
  talk.forget_gap();
  std::vector<Bytes> copies;
  bool forwards = true;
  world.tap = [&](const Bytes& datagram) { copies.push_back(datagram); };
  world.each_step = [&] {
    talk.step();
    const auto heard = std::exchange(copies, {});
    for (const Bytes& datagram : heard) {
      for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
        if (forwards) world.node(peer).on_datagram(datagram, thief, world.now);
      }
    }
  };
  world.run(5 * kSecond);
  CHECK(world.node(1).moves() + world.node(2).moves() == 0);
  CHECK(talk.gap() < 90 * kMs);

  // Where it cuts the way as well, it is the way, and reads nothing. When it stops both are back.
  cut(world, 1, 2);
  world.run(3 * kSecond);
  CHECK(world.node(1).moves() == 1);
  CHECK(world.node(2).moves() == 1);
  forwards = false;
  cut(world, 1, 2, true);
  world.run(kSecond);
  talk.forget_gap();
  world.run(3 * kSecond);
  CHECK(talk.gap() < 90 * kMs);
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
  CHECK(linked(world, 1, 2));
  CHECK(world.node(1).connections() == 1);
}

TEST_CASE("path: two that move at the same time find each other by a third one, and lose nothing",
          "[net][fault]") {
  const double loss = GENERATE(0.0, 0.1);
  World world({.delay = 20 * kMs, .jitter = 5 * kMs, .loss = loss});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.start(3).dial(address_of(1), 0);
  Talk talk(world);
  world.run(2 * kSecond);
  REQUIRE(linked(world, 1, 2));
  REQUIRE(linked(world, 1, 3));
  REQUIRE(linked(world, 2, 3));
  world.each_step = [&] { talk.step(); };
  world.run(kSecond);
  const auto challenged = [&] {
    return world.node(1).strangers().challenged + world.node(2).strangers().challenged;
  };
  const auto before = challenged();
  for (const std::uint8_t host : {std::uint8_t{20}, std::uint8_t{30}}) {
    talk.forget_gap();
    world.move(1, elsewhere(host));
    world.move(2, elsewhere(host + 1));
    world.run(4 * kSecond);
    CHECK(linked(world, 1, 2));
    CHECK(linked(world, 1, 3));
    CHECK(linked(world, 2, 3));
    CHECK(world.node(1).relay().relay_of(2) == 0);
    // The third one follows them as any other, tells, and then they do so. It has sent nothing that
    // tells it the round trip, so it waits half a second for originals. Where what it tells is
    // lost, it tells again after 2 s; idle_timeout, after which they would begin anew, is 5 s.
    INFO("ms without a state " << talk.gap() / kMs);
    CHECK(talk.gap() < (loss == 0.0 ? 1100 : 3500) * kMs);
  }
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
  CHECK(challenged() == before);  // in the same connection
  CHECK(world.node(1).moves() == 2);
  CHECK(world.node(2).moves() == 2);
}

TEST_CASE("path: two alone that move at the same time part with a reason, and resume when dialled",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  Talk talk(world);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  world.each_step = [&] { talk.step(); };
  world.run(kSecond);
  world.move(1, elsewhere(20));
  world.move(2, elsewhere(21));
  world.run(6 * kSecond);
  for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
    const auto other = status(world.node(peer), 3 - peer);
    CHECK_FALSE(other.connected);
    CHECK(other.reason == "connection lost: nothing heard for 5000 ms");
    CHECK(world.node(peer).moves() == 0);
  }
  // Nobody can tell them: somebody has to dial. What waited is sent then, each once and in order.
  world.node(2).dial(elsewhere(20), world.now);
  world.run(2 * kSecond);
  CHECK(linked(world, 1, 2));
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
}

TEST_CASE("path: two alone that move at the same time are one again where one of them comes back",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  Talk talk(world);
  world.run(kSecond);
  world.each_step = [&] { talk.step(); };
  const auto before = world.node(1).strangers().challenged;
  world.move(1, elsewhere(20));
  world.move(2, elsewhere(21));
  world.run(3 * kSecond);
  world.move(1, address_of(1));
  world.run(kSecond);
  CHECK(linked(world, 1, 2));
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
  CHECK(world.node(1).strangers().challenged == before);
}

TEST_CASE("path: false addresses of others move no peer and cause little traffic", "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.start(3).dial(address_of(1), 0);
  world.run(2 * kSecond);
  const auto bytes_to = [&](std::uint8_t host) {
    return world.path(address_of(1), elsewhere(host)).bytes();
  };
  // 3 lies: first of a peer that is heard, then of one that has fallen silent.
  Talk talk(world);
  world.each_step = [&] { talk.step(); };
  world.run(kSecond);
  talk.forget_gap();
  world.each_step = [&] {
    talk.step();
    world.node(1).told(
        3, {.peer = 2, .address = elsewhere(static_cast<std::uint8_t>(50 + world.now / kMs % 100))},
        world.now);
  };
  world.run(3 * kSecond);
  std::uint64_t sent = 0;
  for (std::uint8_t host = 50; host < 150; ++host) sent += bytes_to(host);
  CHECK(sent == 0);
  CHECK(talk.gap() < 60 * kMs);
  cut(world, 1, 2);
  world.run(4 * kSecond);
  for (std::uint8_t host = 50; host < 150; ++host) sent += bytes_to(host);
  CHECK(sent > 0);
  CHECK(sent < 50 * 100);  // ten questions a second at most, of less than 100 bytes with headers
  CHECK(world.node(1).moves() == 0);
  cut(world, 1, 2, true);
  world.run(kSecond);
  CHECK(linked(world, 1, 2));
  talk.end = world.now;
  world.run(2 * kSecond);
  CHECK(talk.is_complete());
}

}  // namespace path_test
