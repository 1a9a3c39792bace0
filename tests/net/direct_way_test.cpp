// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One connection over two ways: a server's, which is slow and sure, and one from socket to socket.
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "sim_link.h"
#include "sim_world.h"
#include "support/catch.h"
#include "udp_node.h"

namespace protocol::direct_way_test {
namespace {

using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;
using tandem::net::Address;
using tandem::net::DirectWay;
using tandem::net::UdpNode;

constexpr std::int64_t kServer = 10 * kMs;  // one way
constexpr std::int64_t kStraight = 2 * kMs;
constexpr std::int64_t kStep = 16 * kMs;

/// Packets that one of two has received from the other.
struct Heard {
  std::vector<std::uint64_t> reliable;
  std::map<std::uint64_t, int> states;  ///< how often each
  std::int64_t last = 0;
  std::int64_t longest_gap = 0;   ///< ns, between two states
  std::int64_t longest_trip = 0;  ///< ns, of a state

  void clear(std::int64_t now) {
    states.clear();
    last = now;
    longest_gap = longest_trip = 0;
  }
};

class Neighbours {
 public:
  explicit Neighbours(std::uint64_t seed = 1)
      : server_{Path({.delay = kServer}, seed), Path({.delay = kServer}, seed + 1)},
        straight_{Path({.delay = kStraight}, seed + 2), Path({.delay = kStraight}, seed + 3)} {
    for (int i = 0; i < 2; ++i) {
      tandem::net::UdpNodeOptions options;
      options.handshake.self = static_cast<PeerId>(i + 1);
      options.handshake.incarnation = 1;
      options.handshake.scene_hash = 42;
      options.handshake.session_key = secret(1000);
      options.handshake.identity = identity_of(static_cast<PeerId>(i + 1));
      options.connection.congestion = {.min_kbit = 2000.0, .max_kbit = 2000.0};
      options.relay = false;
      options.introduces = false;
      options.path_limit = [](std::uint64_t) { return std::size_t{1200}; };
      options.direct_addresses = {where_[at(i)]};
      nodes_[at(i)] = std::make_unique<UdpNode>(
          options, seeded(seed * 100 + at(i)),
          [this, i](std::span<const std::byte> out, const Address& to) { send(i, out, to); });
    }
    nodes_[0]->dial(tandem::net::path_address(2), 0);
  }

  /// Each says a state and a message to the other in each step.
  void run(std::int64_t duration, bool speaks = true) {
    for (const std::int64_t end = now + duration; now < end; now += kMs) {
      for (int i = 0; i < 2; ++i) {
        if (now % kStep == 0) {
          const std::array<PeerId, 1> other{static_cast<PeerId>(2 - i)};
          nodes_[at(i)]->table().prefer_direct(
              wanted[at(i)] ? std::span<const PeerId>(other) : std::span<const PeerId>(), now);
          if (speaks) say(i);
        }
        nodes_[at(i)]->poll(now);
        hear(i);
      }
      for (int i = 0; i < 2; ++i) {
        UdpNode& to = *nodes_[at(1 - i)];
        for (const Bytes& datagram : server_[at(i)].arrived(now)) {
          to.on_path(datagram, static_cast<PeerId>(i + 1), now);
        }
        for (const Bytes& datagram : straight_[at(i)].arrived(now)) {
          to.on_datagram(datagram, where_[at(i)], now);
        }
      }
    }
  }
  void set_straight(const PathOptions& there, const PathOptions& back) {
    straight_[0].set(there);
    straight_[1].set(back);
  }
  bool both_direct() {
    return nodes_[0]->table().direct() == 1 && nodes_[1]->table().direct() == 1;
  }
  UdpNode& node(int i) { return *nodes_[at(i)]; }
  /// The other end reaches it there alone from now on.
  void move(int i, const Address& to) { where_[at(i)] = to; }

  std::int64_t now = 0;
  std::array<bool, 2> wanted{true, true};
  std::array<Heard, 2> heard;
  std::array<std::uint64_t, 2> over_server{};   ///< datagrams that each has sent
  std::array<std::uint64_t, 2> straight_out{};  ///< likewise
  std::map<Address, std::size_t> astray;        ///< datagrams to where nobody is
  std::array<std::uint64_t, 2> said{};
  Bytes last_straight;  ///< of the first

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void send(int from, std::span<const std::byte> out, const Address& to) {
    if (tandem::net::is_path(to)) {
      ++over_server[at(from)];
      server_[at(from)].send(copy(out), now);
    } else if (to == where_[at(1 - from)]) {
      ++straight_out[at(from)];
      if (from == 0) last_straight = copy(out);
      straight_[at(from)].send(copy(out), now);
    } else {
      ++astray[to];
    }
  }
  void say(int from) {
    const auto to = static_cast<PeerId>(2 - from);
    Bytes state = number(1'000'000 + static_cast<std::uint64_t>(now));
    (void)nodes_[at(from)]->post(to, state, Delivery::Newest, now);
    if (nodes_[at(from)]->post(to, number(said[at(from)]), Delivery::Reliable, now)) {
      ++said[at(from)];
    }
  }
  void hear(int i) {
    std::vector<Packet> packets;
    nodes_[at(i)]->drain(packets);
    Heard& here = heard[at(i)];
    for (const Packet& packet : packets) {
      const std::uint64_t value = tandem::pbd::ByteReader(packet.bytes).u64();
      if (value < 1'000'000) {
        here.reliable.push_back(value);
        continue;
      }
      ++here.states[value];
      here.longest_gap = std::max(here.longest_gap, now - here.last);
      here.last = now;
      here.longest_trip =
          std::max(here.longest_trip, now - static_cast<std::int64_t>(value - 1'000'000));
    }
  }

  std::array<Path, 2> server_;
  std::array<Path, 2> straight_;
  std::array<Address, 2> where_{address_of(1), address_of(2)};
  std::array<std::unique_ptr<UdpNode>, 2> nodes_;
};

void check_nothing_lost(Neighbours& pair) {
  pair.run(5 * kSecond, false);
  for (std::size_t i = 0; i < 2; ++i) {
    std::vector<std::uint64_t> all(pair.said[1 - i]);
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    CHECK(pair.heard[i].reliable.size() == all.size());
    CHECK((pair.heard[i].reliable == all));
    CHECK(std::ranges::all_of(pair.heard[i].states, [](const auto& s) { return s.second == 1; }));
  }
}

TEST_CASE("direct way: near peers speak socket to socket alone, far ones over the server",
          "[udp]") {
  Neighbours pair;
  pair.run(3 * kSecond);
  REQUIRE(pair.both_direct());
  const auto before = pair.over_server;
  pair.heard[1].clear(pair.now);
  pair.run(2 * kSecond);
  CHECK(pair.over_server == before);
  CHECK(pair.heard[1].longest_trip <= kStraight + 2 * kMs);
  CHECK(pair.heard[1].longest_gap <= kStep + 2 * kMs);

  // He walks away: at once, and without a gap.
  pair.wanted = {false, false};
  pair.heard[1].clear(pair.now);
  pair.run(kSecond);
  CHECK_FALSE(pair.both_direct());
  CHECK(pair.over_server[0] > before[0] + 40);
  CHECK(pair.heard[1].longest_gap <= kStep + kServer);
  pair.wanted = {true, true};
  pair.run(2 * kSecond);
  CHECK(pair.both_direct());
  check_nothing_lost(pair);
}

TEST_CASE(
    "direct way: where it loses, is cut one way or both, all goes on over the server: nothing "
    "is lost or comes twice, and no gap is longer than the patience",
    "[udp][fault]") {
  const std::uint64_t seed = GENERATE(range(1U, 61U));
  CAPTURE(seed);
  const double loss = 0.05 * static_cast<double>(seed % 6);
  Neighbours pair(seed);
  const PathOptions bad{.delay = kStraight, .jitter = 3 * kMs, .loss = loss, .duplicate = 0.05};
  const PathOptions cut{.loss = 1.1};
  pair.set_straight(bad, bad);
  pair.run(10 * kSecond);
  REQUIRE((pair.both_direct() || loss > 0.2));
  pair.heard[0].clear(pair.now);
  pair.heard[1].clear(pair.now);
  pair.run(10 * kSecond);
  pair.set_straight(seed % 3 == 0 ? bad : cut, seed % 3 == 1 ? bad : cut);
  pair.run(4 * kSecond);
  CHECK_FALSE(pair.both_direct());
  pair.set_straight(bad, bad);
  pair.run(10 * kSecond);
  CHECK((pair.both_direct() || loss > 0.1));
  // DirectWay::patience() of this way, a step before and after it, and the way over the server:
  // packets lost in a row just before are also waited for.
  for (const Heard& each : pair.heard) {
    CHECK(each.longest_gap <= 120 * kMs + 2 * kStep + 2 * kServer);
  }
  check_nothing_lost(pair);
}

TEST_CASE("direct way: one that comes and goes is left alone for longer and longer",
          "[udp][fault]") {
  Neighbours pair;
  pair.run(3 * kSecond);
  REQUIRE(pair.both_direct());
  const PathOptions good{.delay = kStraight};
  const PathOptions cut{.loss = 1.1};
  int rises = 0;
  bool up = true;
  for (int i = 0; i < 60; ++i) {
    pair.set_straight(i % 2 == 0 ? cut : good, i % 2 == 0 ? cut : good);
    for (int k = 0; k < 20; ++k) {
      pair.run(100 * kMs);
      if (!up && pair.both_direct()) ++rises;
      up = pair.both_direct();
    }
  }
  // Of thirty times that it was good for 2 s.
  CHECK(rises >= 2);
  CHECK(rises <= 10);
  pair.set_straight(good, good);
  pair.run(DirectWay::kMaxRest + 3 * kSecond);
  CHECK(pair.both_direct());
  check_nothing_lost(pair);
}

TEST_CASE("direct way: a distant peer is told no address, however often it asks, and is not asked",
          "[udp][fault]") {
  Neighbours pair;
  pair.wanted = {false, true};
  pair.run(10 * kSecond);
  // The second does not know where the first is; the first knows it and does not go there.
  CHECK(pair.straight_out == std::array<std::uint64_t, 2>{});
  CHECK_FALSE(pair.both_direct());
  check_nothing_lost(pair);
}

TEST_CASE("direct way: a peer that names others' addresses as its own has few datagrams sent there",
          "[udp][fault]") {
  Neighbours pair;
  pair.set_straight({.loss = 1.1}, {.loss = 1.1});
  constexpr std::uint16_t kOthers = 100;
  for (int i = 0; i < 2000; ++i) {
    const Address other = address_of(static_cast<PeerId>(1000 + i % kOthers));
    pair.node(1).told(1, {.peer = 1, .address = other}, pair.now);
    pair.wanted[1] = i % 10 != 0;  // nor does it help to walk to and fro
    pair.run(kStep);
  }
  std::size_t sent = 0;
  for (const auto& [address, count] : pair.astray) sent += count;
  // In 32 s five searches: rests are of 1, 2, 4, 8 and 16 s.
  CHECK(sent > 0);
  CHECK(sent <= 5 * DirectWay::kAsks * DirectWay::kMaxOffered);
  CHECK_FALSE(pair.both_direct());
  check_nothing_lost(pair);
}

TEST_CASE("direct way: a peer is found at its new address", "[udp]") {
  Neighbours pair;
  pair.run(3 * kSecond);
  REQUIRE(pair.both_direct());
  // A NAT gives it another port, of which it does not know.
  Address elsewhere = address_of(2);
  elsewhere.port += 1;
  pair.move(1, elsewhere);
  pair.run(8 * kSecond);
  CHECK(pair.both_direct());
  check_nothing_lost(pair);
}

TEST_CASE("direct way: a copy of a packet from another address moves nobody there",
          "[udp][fault]") {
  Neighbours pair;
  pair.run(3 * kSecond);
  REQUIRE(pair.both_direct());
  const Address stranger = address_of(77);
  for (int i = 0; i < 200; ++i) {
    pair.node(1).on_datagram(pair.last_straight, stranger, pair.now);
    pair.run(kStep);
  }
  CHECK(pair.node(1).unknown() == 200);
  CHECK(pair.both_direct());
  CHECK(pair.astray[stranger] == 0);
  // Also one that is faster than the original: then it is asked there, a few times, and no more.
  pair.set_straight({.loss = 1.1}, {.loss = 1.1});
  for (int i = 0; i < 200; ++i) {
    pair.node(1).on_datagram(pair.last_straight, stranger, pair.now);
    pair.run(kStep);
  }
  CHECK(pair.astray[stranger] <= 4 * DirectWay::kAsks);
  CHECK_FALSE(pair.both_direct());
  check_nothing_lost(pair);
}

}  // namespace
}  // namespace protocol::direct_way_test
