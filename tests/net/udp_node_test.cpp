// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Whole processes but for their sockets, over seeded paths, in virtual time.
#include "udp_node.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>

#include "sim_link.h"
#include "support/catch.h"
#include "tandem/pbd/bytes.h"

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;
using tandem::consensus::PeerStatus;

namespace {

Address address_of(PeerId peer) {
  return {
      .ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 10, 0, 0, static_cast<std::uint8_t>(peer)},
      .port = 4000};
}

class World {
 public:
  explicit World(const PathOptions& path = {}) : path_(path) {}

  UdpNode& start(PeerId peer, std::uint64_t incarnation = 1, std::size_t max_peers = 64) {
    UdpNodeOptions options;
    options.handshake.self = peer;
    options.handshake.incarnation = incarnation;
    options.handshake.scene_hash = 42;
    options.max_peers = max_peers;
    options.handshake.session_key = secret(1000);
    options.handshake.identity = crypto::make_key_pair(seeded(500 + ++starts_));
    nodes_[peer] =
        std::make_unique<UdpNode>(options, seeded(7000 + starts_),
                                  [this, peer](std::span<const std::byte> out, const Address& to) {
                                    tap(copy(out));
                                    path(address_of(peer), to).send(copy(out), now);
                                  });
    return *nodes_[peer];
  }
  /// Hears all that is sent, whoever it is for.
  std::function<void(const Bytes&)> tap = [](const Bytes&) {};
  void stop(PeerId peer) { nodes_.erase(peer); }
  UdpNode& node(PeerId peer) { return *nodes_.at(peer); }
  Path& path(const Address& from, const Address& to) {
    return paths_.try_emplace({from, to}, path_, paths_.size() + 1).first->second;
  }

  void run(std::int64_t duration) {
    for (const std::int64_t end = now + duration; now < end; now += kMs) {
      each_step();
      for (auto& [peer, node] : nodes_) node->poll(now);
      for (auto& [ends, path] : paths_) {
        const Address target = ends.second;
        const auto to = std::ranges::find_if(
            nodes_, [&target](const auto& entry) { return address_of(entry.first) == target; });
        for (const Bytes& datagram : path.arrived(now)) {
          if (to != nodes_.end()) to->second->on_datagram(datagram, ends.first, now);
        }
      }
    }
  }

  std::function<void()> each_step = [] {};
  std::int64_t now = 0;

 private:
  PathOptions path_;
  std::map<std::pair<Address, Address>, Path> paths_;
  std::map<PeerId, std::unique_ptr<UdpNode>> nodes_;
  std::uint64_t starts_ = 0;
};

PeerStatus status(const UdpNode& node, PeerId peer) {
  for (const PeerStatus& each : node.peers()) {
    if (each.id == peer) return each;
  }
  return {};
}

bool linked(World& world, PeerId a, PeerId b) {
  return status(world.node(a), b).connected && status(world.node(b), a).connected;
}

Bytes number(std::uint64_t value) {
  Bytes out;
  tandem::pbd::ByteWriter(out).u64(value);
  return out;
}

}  // namespace

TEST_CASE("udp node: four peers that all dial each other have one connection each", "[net]") {
  World world({.delay = 30 * kMs, .jitter = 10 * kMs, .loss = 0.05});
  for (PeerId peer = 1; peer <= 4; ++peer) {
    UdpNode& node = world.start(peer);
    for (PeerId other = 1; other <= 4; ++other) {
      if (other != peer) node.dial(address_of(other), 0);
    }
  }
  world.run(3 * kSecond);
  for (PeerId a = 1; a <= 4; ++a) {
    CHECK(world.node(a).connections() == 3);
    for (PeerId b = 1; b < a; ++b) CHECK(linked(world, a, b));
  }

  std::map<std::pair<PeerId, PeerId>, std::uint64_t> next;
  std::map<std::pair<PeerId, PeerId>, std::uint64_t> states;
  std::uint64_t posted = 0;
  world.each_step = [&] {
    const bool posts = posted < 300 && world.now % (16 * kMs) == 0;
    for (PeerId a = 1; a <= 4; ++a) {
      for (PeerId b = 1; posts && b <= 4; ++b) {
        if (a == b) continue;
        REQUIRE(world.node(a).post(b, number(posted), Delivery::Reliable, world.now));
        REQUIRE(world.node(a).post(b, Bytes(200), Delivery::Newest, world.now));
      }
      std::vector<Packet> got;
      world.node(a).drain(got);
      for (const Packet& packet : got) {
        if (packet.bytes.size() == 200) {
          ++states[{packet.from, a}];
        } else {
          CHECK(tandem::pbd::ByteReader(packet.bytes).u64() == next[{packet.from, a}]++);
        }
      }
    }
    posted += posts ? 1 : 0;
  };
  world.run(10 * kSecond);
  CHECK(next.size() == 12);
  for (const auto& [ends, count] : next) CHECK(count == 300);
  for (const auto& [ends, count] : states) CHECK(count > 250);  // 5 % lost: 285 expected
}

TEST_CASE("udp node: a restarted peer takes over at once, its predecessor is refused",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2, 10).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  world.stop(2);  // without a word
  world.start(2, 11).dial(address_of(1), world.now);
  world.run(200 * kMs);
  CHECK(linked(world, 1, 2));
  CHECK(world.node(1).connections() <= 2);  // one of them says goodbye
  world.run(kSecond);
  CHECK(world.node(1).connections() == 1);

  world.stop(2);
  world.run(6 * kSecond);
  CHECK_FALSE(status(world.node(1), 2).connected);
  world.start(2, 10).dial(address_of(1), world.now);
  world.run(3 * kSecond);
  CHECK_FALSE(status(world.node(1), 2).connected);
}

TEST_CASE("udp node: a cut path heals by itself", "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  world.path(address_of(1), address_of(2)).set({.loss = 1.1});
  world.path(address_of(2), address_of(1)).set({.loss = 1.1});
  world.run(6 * kSecond);
  CHECK_FALSE(status(world.node(1), 2).connected);
  CHECK_FALSE(status(world.node(2), 1).connected);
  CHECK(status(world.node(2), 1).reason.find("nothing heard") != std::string::npos);
  world.run(5 * kSecond);
  CHECK(status(world.node(2), 1).reason == "no answer");  // it has tried
  world.path(address_of(1), address_of(2)).set({.delay = 20 * kMs});
  world.path(address_of(2), address_of(1)).set({.delay = 20 * kMs});
  world.run(9 * kSecond);  // an attempt that began in the dark ends after 5 s, then 3 s of waiting
  CHECK(linked(world, 1, 2));
}

TEST_CASE("udp node: a dropped peer is told, stays away, and comes back when the hold is over",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  world.node(1).drop(2, "talks nonsense", world.now);
  world.run(500 * kMs);
  CHECK_FALSE(status(world.node(1), 2).connected);
  CHECK(status(world.node(1), 2).reason == "dropped: talks nonsense");
  CHECK_FALSE(world.node(1).post(2, number(1), Delivery::Newest, world.now));
  world.run(5 * kSecond);
  CHECK(linked(world, 1, 2));
}

TEST_CASE("udp node: a session goes on through a flood of junk, recordings and spoofed addresses",
          "[net][fault]") {
  // The attacker hears everything from the first Hello on, and can use any address.
  World world({.delay = 10 * kMs});
  std::vector<Bytes> heard;
  world.tap = [&](const Bytes& datagram) { heard.push_back(datagram); };
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  Dice dice(6);
  std::uint64_t posted = 0;
  std::uint64_t got = 0;
  world.each_step = [&] {
    if (world.now % (16 * kMs) == 0 && world.now < 5 * kSecond) {
      REQUIRE(world.node(2).post(1, number(posted++), Delivery::Newest, world.now));
    }
    std::vector<Packet> packets;
    world.node(1).drain(packets);
    for (const Packet& packet : packets) {
      CHECK(packet.from == 2);
      CHECK(tandem::pbd::ByteReader(packet.bytes).u64() == got++);
    }
    for (int i = 0; i < 20; ++i) {  // 20 k per s
      Bytes junk = random_bytes(dice, dice.below(1250));
      if (dice.chance(0.5)) junk = heard[dice.below(heard.size())];
      // Also what has not arrived yet: then the copy counts, and the original is the replay.
      if (!junk.empty() && dice.chance(0.3)) junk[dice.below(junk.size())] ^= std::byte{4};
      const PeerId from = dice.chance(0.5) ? 2 : 3 + dice.below(200);
      world.node(1).on_datagram(junk, address_of(from), world.now);
    }
  };
  world.run(5 * kSecond);
  CHECK(got == posted);
  CHECK(linked(world, 1, 2));
  CHECK(world.node(1).connections() == 1);
  CHECK(status(world.node(1), 2).rejected == 0);
}

TEST_CASE("udp node: no more peers than there is room for", "[net][fault]") {
  World world({.delay = 5 * kMs});
  world.start(1, 1, 3);
  for (PeerId peer = 2; peer <= 6; ++peer) world.start(peer).dial(address_of(1), 0);
  world.run(5 * kSecond);
  std::size_t connected = 0;
  for (const PeerStatus& each : world.node(1).peers()) connected += each.connected ? 1 : 0;
  CHECK(connected == 3);
  CHECK(world.node(1).strangers().refused > 0);
}
