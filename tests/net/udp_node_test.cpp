// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Whole processes but for their sockets, over seeded paths, in virtual time.
#include "udp_node.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>

#include "sim_world.h"
#include "support/catch.h"
#include "tandem/pbd/bytes.h"

namespace udp_node_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;
using tandem::consensus::PeerStatus;

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

TEST_CASE("udp node: a restarted peer takes over at once", "[net][fault]") {
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
}

TEST_CASE("udp node: a peer with its clock set back is admitted after its predecessor",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2, 1'000'000).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  // Without a word, and at once with an earlier clock.
  world.stop(2);
  world.start(2, 10).dial(address_of(1), world.now);
  world.run(kSecond);
  CHECK_FALSE(status(world.node(2), 1).connected);
  world.run(2 * kSecond);
  CHECK(linked(world, 1, 2));
  // Long after the other one has been forgotten.
  world.stop(2);
  world.run(6 * kSecond);
  CHECK_FALSE(status(world.node(1), 2).connected);
  world.start(2, 5).dial(address_of(1), world.now);
  world.run(kSecond);
  CHECK(linked(world, 1, 2));
}

TEST_CASE("udp node: a peer restarted after its clock was set acts again within three seconds",
          "[net][clock][fault]") {
  constexpr std::int64_t kDay = 86'400 * kSecond;
  const std::int64_t step = GENERATE(-30 * kDay, -60 * kSecond, 60 * kSecond, 30 * kDay);
  constexpr std::int64_t kSince = 20'000 * kDay;  // 1970
  World world({.delay = 20 * kMs, .jitter = 4 * kMs});
  std::map<PeerId, std::int64_t> set;
  world.change = [&](UdpNodeOptions& options) {
    options.correction = kSince + set[options.handshake.self];
    options.handshake.incarnation =
        static_cast<std::uint64_t>(options.correction + options.start) + 1;
  };
  for (PeerId peer = 1; peer <= 3; ++peer) {
    UdpNode& node = world.start(peer);
    for (PeerId other = 1; other < peer; ++other) node.dial(address_of(other), 0);
  }
  world.run(5 * kSecond);
  const SessionTime began = world.node(2).session_now(world.now) - world.now;
  std::int64_t moved = 0;
  std::map<std::pair<PeerId, PeerId>, std::uint64_t> heard;
  world.each_step = [&] {
    moved = std::max(moved, std::abs(world.node(2).session_now(world.now) - world.now - began));
    for (PeerId peer = 1; peer <= 3; ++peer) {
      for (PeerId other = 1; other <= 3 && world.now % (16 * kMs) == 0; ++other) {
        if (other != peer) {
          (void)world.node(peer).post(other, number(1), Delivery::Newest, world.now);
        }
      }
      std::vector<Packet> packets;
      world.node(peer).drain(packets);
      for (const Packet& packet : packets) ++heard[{packet.from, peer}];
    }
  };
  // A member, and then the one whose clock it is; set by so much more each time.
  for (const PeerId peer : {PeerId{3}, PeerId{1}}) {
    set[peer] += peer == 3 ? step : 2 * step;
    UdpNode& node = world.start(peer);  // without a word, and at once
    for (PeerId other = 1; other <= 3; ++other) {
      if (other != peer) node.dial(address_of(other), world.now);
    }
    world.run(3 * kSecond);
    heard.clear();
    for (PeerId other = 1; other <= 3; ++other) {
      if (other == peer) continue;
      CHECK(linked(world, peer, other));
      CHECK(std::abs(world.node(peer).session_now(world.now) -
                     world.node(other).session_now(world.now)) < 5 * kMs);
    }
    world.run(kSecond);
    CHECK(heard.size() == 6);
    for (const auto& [ends, count] : heard) CHECK(count > 55);
  }
  // Nobody else's time has moved, but by the drift that is allowed for.
  CHECK(moved < 10 * kMs);
}

TEST_CASE("udp node: of two processes with one id the later one stays", "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2, 11).dial(address_of(1), 0);
  world.run(kSecond);
  HandshakeConfig config;
  config.self = 2;
  config.incarnation = 10;
  config.scene_hash = 42;
  config.session_key = secret(1000);
  config.identity = identity_of(2);
  config.complete(2);
  for (int attempt = 0; attempt < 10; ++attempt) {
    HandshakeInitiator initiator(config, seeded(static_cast<std::uint64_t>(attempt)), 7, world.now);
    for (int i = 0; i < 500 && initiator.state() != HandshakeInitiator::State::Refused; ++i) {
      const Bytes question = copy(initiator.poll(world.now));
      if (!question.empty()) world.node(1).on_datagram(question, address_of(40), world.now);
      world.run(kMs);
      for (const Bytes& answer : world.path(address_of(1), address_of(40)).arrived(world.now)) {
        initiator.on_datagram(answer, world.now);
      }
    }
    CHECK(initiator.state() == HandshakeInitiator::State::Refused);
    CHECK(initiator.verdict() == Verdict::Outdated);
    CHECK(linked(world, 1, 2));
    world.run(300 * kMs);
  }
}

TEST_CASE("udp node: a member that makes up ids keeps nobody out and is forgotten",
          "[net][fault]") {
  World world({.delay = kMs});
  world.start(1, 1, 8);
  world.start(3).dial(address_of(1), 0);
  world.run(kSecond);
  for (PeerId id = 1000; id < 1100; ++id) {
    world.start(id).dial(address_of(1), world.now);
    world.run(50 * kMs);
    world.node(id).leave("gone", world.now);
    world.run(100 * kMs);
    world.stop(id);
  }
  CHECK(linked(world, 1, 3));  // was there all the time
  CHECK(world.node(1).peers().size() <= 16);
  world.start(2).dial(address_of(1), world.now);
  world.run(kSecond);
  CHECK(linked(world, 1, 2));
}

TEST_CASE("udp node: a returning peer has a place even if all were taken meanwhile",
          "[net][fault]") {
  World world({.delay = kMs});
  world.start(1, 1, 4);
  for (const PeerId regular : {2, 3}) world.start(regular).dial(address_of(1), world.now);
  world.run(12 * kSecond);
  cut(world, 1, 2);
  world.run(6 * kSecond);
  REQUIRE_FALSE(status(world.node(1), 2).connected);
  // One member as many.
  for (PeerId id = 100; id < 110; ++id) {
    world.start(id).dial(address_of(1), world.now);
    world.run(20 * kMs);
  }
  const auto present = [&] {
    const auto all = world.node(1).peers();
    return std::ranges::count_if(all, [](const auto& each) { return each.connected; });
  };
  REQUIRE(present() == 4);
  // A newcomer is told why he is not let in.
  world.start(4).dial(address_of(1), world.now);
  world.run(2 * kSecond);
  CHECK(status(world.node(4), 1).reason == describe(Verdict::Full));
  // However long they have been there, and though they ask again.
  world.run(12 * kSecond);
  cut(world, 1, 2, true);
  world.run(4 * kSecond);
  for (int i = 0; i < 200; ++i) {
    world.run(kSecond / 10);
    CHECK(linked(world, 1, 2));
    CHECK(linked(world, 1, 3));
  }
  CHECK(present() == 4);
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

TEST_CASE("udp node: reliable messages outlive connections, each once and in order",
          "[net][fault]") {
  World world({.delay = 20 * kMs, .jitter = 10 * kMs, .loss = 0.1, .duplicate = 0.1});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(2 * kSecond);
  REQUIRE(linked(world, 1, 2));
  std::map<PeerId, std::uint64_t> posted;
  std::map<PeerId, std::uint64_t> got;
  int outages = 0;
  world.each_step = [&] {
    for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
      // Messages of several pieces, so that connections break in the middle of one.
      if (world.now % (20 * kMs) == 0 && world.now < 60 * kSecond) {
        Bytes message = number(posted[peer]);
        message.resize(8 + posted[peer] % 3000);
        const PeerId other = 3 - peer;
        posted[peer] +=
            world.node(peer).post(other, message, Delivery::Reliable, world.now) ? 1 : 0;
      }
      std::vector<Packet> packets;
      world.node(peer).drain(packets);
      for (const Packet& packet : packets) {
        REQUIRE(packet.bytes.size() >= 8);
        REQUIRE(tandem::pbd::ByteReader(packet.bytes).u64() == got[packet.from]);
        REQUIRE(packet.bytes.size() == 8 + got[packet.from] % 3000);
        ++got[packet.from];
      }
    }
    // One end notices before the other, or both at once.
    const std::int64_t phase = world.now < 60 * kSecond ? world.now % (12 * kSecond) : 0;
    if (phase == 3 * kSecond) {
      world.path(address_of(1), address_of(2)).set({.loss = 1.1});
      if (outages++ % 2 == 0) world.path(address_of(2), address_of(1)).set({.loss = 1.1});
    }
    if (phase == 8 * kSecond + 500 * kMs) {
      world.path(address_of(1), address_of(2)).set({.delay = 20 * kMs, .loss = 0.1});
      world.path(address_of(2), address_of(1)).set({.delay = 20 * kMs, .loss = 0.1});
    }
  };
  world.run(60 * kSecond);
  world.path(address_of(1), address_of(2)).set({.delay = 20 * kMs});
  world.path(address_of(2), address_of(1)).set({.delay = 20 * kMs});
  world.run(60 * kSecond);
  CHECK(outages == 5);
  CHECK(posted[1] > 500);
  CHECK(posted[2] > 500);
  CHECK(got[1] == posted[1]);
  CHECK(got[2] == posted[2]);
}

TEST_CASE("udp node: a dropped peer and a restarted one begin with an empty queue",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2, 10).dial(address_of(1), 0);
  world.run(kSecond);
  const auto first = [&](PeerId at) {
    std::vector<Packet> packets;
    world.node(at).drain(packets);
    return packets.empty() ? std::uint64_t{0} : tandem::pbd::ByteReader(packets[0].bytes).u64();
  };
  for (std::uint64_t i = 1; i <= 3; ++i) {
    REQUIRE(world.node(1).post(2, number(i), Delivery::Reliable, world.now));
  }
  world.run(200 * kMs);
  CHECK(first(2) == 1);
  REQUIRE(world.node(1).post(2, number(4), Delivery::Reliable, world.now));
  world.node(1).drop(2, "test", world.now);
  world.run(6 * kSecond);
  REQUIRE(linked(world, 1, 2));
  REQUIRE(world.node(1).post(2, number(5), Delivery::Reliable, world.now));
  world.run(200 * kMs);
  CHECK(first(2) == 5);  // 4 was discarded, the stream goes on all the same

  cut(world, 1, 2);
  REQUIRE(world.node(1).post(2, number(6), Delivery::Reliable, world.now));
  world.run(100 * kMs);
  world.stop(2);
  cut(world, 1, 2, true);
  world.start(2, 11).dial(address_of(1), world.now);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 2));
  CHECK(first(2) == 0);
  REQUIRE(world.node(1).post(2, number(7), Delivery::Reliable, world.now));
  world.run(200 * kMs);
  CHECK(first(2) == 7);
}

TEST_CASE("udp node: all have one time, also where one of them came late", "[net][clock]") {
  World world({.delay = 20 * kMs, .jitter = 4 * kMs});
  world.start(2);
  world.start(3).dial(address_of(2), 0);
  world.run(6 * kSecond);
  world.start(1).dial(address_of(3), world.now);
  world.run(10 * kSecond);
  for (PeerId peer = 1; peer <= 3; ++peer) {
    const auto clock = world.node(peer).clock(world.now);
    CHECK(clock.synchronised);
    CHECK(clock.faults == 0);
    CHECK(clock.reference == 1);
    CHECK(std::abs(clock.now - world.node(1).session_now(world.now)) < 3 * kMs);
    CHECK(clock.error_bound < 30 * kMs);
  }
}

TEST_CASE("udp node: strangers get no more bytes than they send and keep no peer out",
          "[net][fault]") {
  // Strangers at 200 addresses who ask, take a cookie and say no more; the attacker hears all.
  World world({.delay = 10 * kMs});
  world.start(1);
  std::map<PeerId, std::size_t> asked;
  Dice dice(8);
  std::vector<Bytes> heard;
  world.tap = [&](const Bytes& datagram) { heard.push_back(datagram); };
  world.each_step = [&] {
    for (int i = 0; i < 5; ++i) {
      const PeerId stranger = 20 + dice.below(200);
      Bytes question;
      if (heard.empty() || dice.chance(0.8)) {
        encode(HandshakePacket{.type = HandshakeType::Hello, .nonce = dice.next()}, question);
      } else {  // also another's proof
        question = heard[dice.below(heard.size())];
      }
      asked[stranger] += question.size();
      world.node(1).on_datagram(question, address_of(stranger), world.now);
    }
  };
  world.run(3 * kSecond);
  world.start(2).dial(address_of(1), world.now);
  world.run(2 * kSecond);
  CHECK(linked(world, 1, 2));
  CHECK(world.node(1).connections() == 1);
  CHECK(world.node(1).strangers().challenged > 1000);
  for (const auto& [stranger, bytes] : asked) {
    const std::uint64_t answered = world.path(address_of(1), address_of(stranger)).bytes();
    CHECK(answered <= bytes + bytes / 64 * tandem::net::kIpUdpBytes);
  }
}

TEST_CASE("udp node: a member that begins connections and never goes on fills nothing for long",
          "[net][fault]") {
  World world({.delay = kMs});
  world.start(1, 1, 8);
  // It has the session key: many proofs, of which none is followed by a packet.
  std::map<std::uint64_t, std::uint64_t> asked;
  for (PeerId id = 100; id < 140; ++id) {
    HandshakeConfig config;
    config.self = id;
    config.incarnation = 1;
    config.scene_hash = 42;
    config.session_key = secret(1000);
    config.identity = crypto::make_key_pair(seeded(id));
    config.complete(id);
    HandshakeInitiator initiator(config, seeded(id), 7, world.now);
    const Address from = address_of(id % 3 + 30);
    for (int i = 0; i < 200 && initiator.state() != HandshakeInitiator::State::Done; ++i) {
      const Bytes question = copy(initiator.poll(world.now));
      if (!question.empty()) world.node(1).on_datagram(question, from, world.now);
      asked[id % 3 + 30] += question.size() + (question.empty() ? 0 : kIpUdpBytes);
      world.run(kMs);
      for (const Bytes& answer : world.path(address_of(1), from).arrived(world.now)) {
        initiator.on_datagram(answer, world.now);
      }
    }
  }
  CHECK(world.node(1).connections() <= 40);
  // The answers of their handshakes, no longer than the questions, and nothing else.
  for (std::uint64_t i = 30; i < 33; ++i) {
    CHECK(world.path(address_of(1), address_of(i)).bytes() <= asked[i]);
  }
  world.run(6 * kSecond);  // idle_timeout
  CHECK(world.node(1).connections() == 0);
  world.start(2).dial(address_of(1), world.now);
  world.run(kSecond);
  CHECK(linked(world, 1, 2));
}

}  // namespace udp_node_test
