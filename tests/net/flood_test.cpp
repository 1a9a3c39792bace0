// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What strangers without the session key can do to who wants to join: nothing, in virtual time.
#include <malloc.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "handshake_wire.h"
#include "sim_world.h"
#include "support/catch.h"
#include "tandem/pbd/cpu_timer.h"

namespace flood_test {

using namespace tandem::net;
using namespace protocol;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;

namespace {

/// Bytes that are in use; 0 where malloc is not glibc's.
std::size_t in_use() {
#ifdef __GLIBC__
  return ::mallinfo2().uordblks + ::mallinfo2().hblkhd;
#else
  return 0;
#endif
}

/// One of `count` hosts outside the session.
Address stranger(std::uint64_t number) {
  Address out = address_of(1);
  out.ip[12] = 172;
  out.ip[13] = static_cast<std::uint8_t>(number >> 16);
  out.ip[14] = static_cast<std::uint8_t>(number >> 8);
  out.ip[15] = static_cast<std::uint8_t>(number);
  return out;
}

/// Packets that an attacker can write without a key or an answer, and recorded ones.
class Flood {
 public:
  explicit Flood(World& world) : world_(world) {
    world.tap = [this](const Bytes& datagram) {
      if (heard_.size() < 500) heard_.push_back(datagram);
    };
  }

  void send(const Address& from) {
    ++sent;
    world_.node(1).on_datagram(packet(), from, world_.now);
  }
  Dice dice{11};
  std::uint64_t sent = 0;

 private:
  Bytes packet() {
    Bytes out;
    const double kind = static_cast<double>(dice.below(100));
    if (kind < 40) {
      encode({.type = HandshakeType::Hello, .nonce = dice.next()}, out);
    } else if (kind < 70) {
      encode({.type = HandshakeType::Initiate, .nonce = dice.next(), .noise = noise_}, out);
    } else if (kind < 85 && !heard_.empty()) {
      out = heard_[dice.below(heard_.size())];
    } else {
      out = random_bytes(dice, dice.below(1250));
    }
    return out;
  }
  World& world_;
  std::vector<Bytes> heard_;
  std::vector<std::uint8_t> noise_ = std::vector<std::uint8_t>(258, 7);
};

/// Begins handshakes from many addresses and says no more: with keys of one member, or of as many
/// as it has made up.
class Beginner {
 public:
  Beginner(World& world, std::size_t keys) : world_(world) {
    for (std::size_t i = 0; i < keys; ++i) {
      HandshakeConfig& config = configs_.emplace_back();
      config.self = 1000 + i;
      config.incarnation = 1;
      config.scene_hash = 42;
      config.session_key = secret(1000);
      config.identity = crypto::make_key_pair(seeded(1000 + i));
      config.complete(config.self);
    }
  }

  /// A handshake from the next of the addresses, and what is to be said to those under way.
  void begin(const std::vector<Address>& from) {
    const Address& address = from[begun_ % from.size()];
    world_.watch(address);
    const HandshakeConfig& config = configs_[begun_ % configs_.size()];
    under_way_.push_back({address, std::make_unique<HandshakeInitiator>(
                                       config, seeded(90'000 + begun_),
                                       static_cast<std::uint32_t>(1 + begun_), world_.now)});
    ++begun_;
  }
  void step() {
    std::map<Address, std::vector<Bytes>> answers;
    for (const Attempt& each : under_way_) {
      if (!answers.contains(each.from)) {
        answers[each.from] = world_.arrived(address_of(1), each.from);
      }
      for (const Bytes& answer : answers[each.from]) {
        each.handshake->on_datagram(answer, world_.now);
      }
      const auto out = each.handshake->poll(world_.now);
      if (!out.empty()) world_.node(1).on_datagram(copy(out), each.from, world_.now);
    }
    done += static_cast<std::uint64_t>(std::erase_if(under_way_, [](const Attempt& each) {
      return each.handshake->state() != HandshakeInitiator::State::Asking &&
             each.handshake->state() != HandshakeInitiator::State::Proving;
    }));
  }
  std::uint64_t done = 0;

 private:
  struct Attempt {
    Address from;
    std::unique_ptr<HandshakeInitiator> handshake;
  };
  World& world_;
  std::deque<HandshakeConfig> configs_;
  std::vector<Attempt> under_way_;
  std::uint64_t begun_ = 0;
};

}  // namespace

TEST_CASE("flood: 300 handshakes a second of a member do not keep out a peer at 250 ms",
          "[net][fault]") {
  World world({.delay = kMs});
  world.start(1);
  // One key from many networks, or many keys from one, or both.
  const auto [keys, networks] = GENERATE(std::pair(1, 250), std::pair(300, 1), std::pair(300, 250));
  std::vector<Address> from;
  for (std::uint64_t i = 0; i < 250; ++i) {
    from.push_back(stranger(networks == 1 ? i : i << 8));
  }
  Beginner beginner(world, static_cast<std::size_t>(keys));
  int due = 0;
  world.each_step = [&] {
    for (due += 3; due >= 10; due -= 10) beginner.begin(from);
    beginner.step();
  };
  world.run(2 * kSecond);
  CHECK(beginner.done > 400);
  for (PeerId newcomer = 2; newcomer < 5; ++newcomer) {
    const PathOptions far{.delay = 125 * kMs};
    world.path(address_of(1), address_of(newcomer)).set(far);
    world.path(address_of(newcomer), address_of(1)).set(far);
    world.start(newcomer).dial(address_of(1), world.now);
    bool is_sure = true;  // nobody says that he is connected who is not let in
    for (int i = 0; i < 20; ++i) {
      world.run(100 * kMs);
      is_sure = is_sure && (status(world.node(1), newcomer).connected ||
                            !status(world.node(newcomer), 1).connected);
    }
    CHECK(is_sure);
    CAPTURE(keys, networks);
    CHECK(linked(world, 1, newcomer));
  }
}

TEST_CASE("flood: a peer that is accepted and then cut off does not report a connection",
          "[net][fault]") {
  World world({.delay = 20 * kMs});
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(60 * kMs);  // question, cookie, proof
  cut(world, 1, 2);     // the answer is on its way, nothing under the keys will be
  world.run(3 * kSecond);
  CHECK_FALSE(status(world.node(2), 1).connected);
  cut(world, 1, 2, true);
  world.run(2 * kSecond);
  CHECK(linked(world, 1, 2));
}

TEST_CASE(
    "flood: with 2000 spoofed packets a second in its address and 20 000 from others a newcomer "
    "joins within a second",
    "[net][fault]") {
  World world({.delay = 20 * kMs});
  Flood flood(world);
  world.start(1);
  world.start(3).dial(address_of(1), 0);
  world.run(kSecond);
  REQUIRE(linked(world, 1, 3));
  PeerId victim = 2;
  std::uint64_t posted = 0;
  std::uint64_t got = 0;
  const auto step = [&] {
    for (int i = 0; i < 2; ++i) flood.send(address_of(victim));
    for (int i = 0; i < 20; ++i) flood.send(stranger(flood.dice.below(4096)));
    if (world.now % (16 * kMs) == 0) {
      posted += world.node(3).post(1, number(posted), Delivery::Newest, world.now) ? 1 : 0;
    }
    std::vector<Packet> packets;
    world.node(1).drain(packets);
    got += static_cast<std::uint64_t>(
        std::ranges::count_if(packets, [](const Packet& packet) { return packet.from == 3; }));
  };
  world.each_step = step;
  world.run(2 * kSecond);
  for (victim = 4; victim < 9; ++victim) {
    world.start(victim).dial(address_of(1), world.now);
    world.run(kSecond);
    CHECK(linked(world, 1, victim));
  }
  CHECK(flood.sent == 22 * 7000);
  CHECK(linked(world, 1, 3));
  world.each_step = [&] {
    std::vector<Packet> packets;
    world.node(1).drain(packets);
    got += static_cast<std::uint64_t>(
        std::ranges::count_if(packets, [](const Packet& packet) { return packet.from == 3; }));
  };
  world.run(kSecond);
  CHECK(posted > 400);
  CHECK(got == posted);  // no packet of a member was lost to it
}

TEST_CASE(
    "flood: ten thousand replays of a recorded proof keep a mebibyte at most, give it back, refuse "
    "nobody and are answered with less than came",
    "[net][fault]") {
  World world({.delay = 5 * kMs});
  std::vector<Bytes> recorded;
  world.tap = [&](const Bytes& datagram) { recorded.push_back(datagram); };
  world.start(1);
  world.start(2).dial(address_of(1), 0);
  world.run(200 * kMs);
  REQUIRE(linked(world, 1, 2));
  world.tap = [](const Bytes&) {};
  const auto of_type = [&](HandshakeType type) {
    return *std::ranges::find_if(recorded, [type](const Bytes& datagram) {
      const auto packet = decode_handshake(datagram);
      return packet && packet->type == type;
    });
  };
  const Bytes hello = of_type(HandshakeType::Hello);
  const Bytes proof = of_type(HandshakeType::Initiate);
  const auto nonce = decode_handshake(hello)->nonce;
  const auto noise = decode_handshake(proof)->noise;
  constexpr std::uint64_t kHosts = 250;
  for (std::uint64_t i = 0; i < kHosts; ++i) {
    world.watch(stranger(i));
    world.path(address_of(1), stranger(i));  // so that it is no memory of the node's
  }

  std::uint64_t replays = 0;
  std::uint64_t came = 0;
  std::size_t most = 0;
  const auto from_elsewhere = [&] {
    for (std::uint64_t i = 0; i < kHosts; ++i) {
      // With cookies of their own, as they get one for the asking.
      for (const Bytes& answer : world.arrived(address_of(1), stranger(i))) {
        const auto challenge = decode_handshake(answer);
        if (!challenge || challenge->type != HandshakeType::Challenge) continue;
        Bytes again;
        encode({.type = HandshakeType::Initiate,
                .nonce = nonce,
                .cookie = challenge->cookie,
                .noise = noise},
               again);
        world.node(1).on_datagram(again, stranger(i), world.now);
        came += again.size() + kIpUdpBytes;
        ++replays;
      }
    }
    for (int i = 0; i < 2; ++i) {
      const Address host = stranger((replays + static_cast<std::uint64_t>(i)) % kHosts);
      world.node(1).on_datagram(hello, host, world.now);
      came += hello.size() + kIpUdpBytes;
    }
  };
  const std::size_t before = in_use();
  world.each_step = [&] {
    from_elsewhere();
    world.node(1).on_datagram(proof, address_of(2), world.now);  // and from its own, as it was
    most = std::max(most, in_use());
  };
  world.run(6 * kSecond);
  CHECK(replays > 10'000);
  CHECK(most <= before + (std::size_t{1} << 20));
  CHECK(world.node(1).connections() == 1);
  CHECK(linked(world, 1, 2));
  world.each_step = [] {};
  world.run(6 * kSecond);
  CHECK(in_use() <= before + (std::size_t{64} << 10));
  std::uint64_t answered = 0;
  for (std::uint64_t i = 0; i < kHosts; ++i) {
    answered += world.path(address_of(1), stranger(i)).bytes();
  }
  CHECK(answered > 0);
  CHECK(answered < came);

  world.each_step = from_elsewhere;
  for (PeerId newcomer = 4; newcomer < 9; ++newcomer) {
    world.start(newcomer).dial(address_of(1), world.now);
    world.run(kSecond);
    CHECK(linked(world, 1, newcomer));
  }
  CHECK(replays > 18'000);
  CHECK(world.node(1).strangers().refused == 0);
}

// The cost of a stranger's datagram, for docs/history/network-figures.md; not a test.
TEST_CASE("measure: processor time of a stranger's datagram", "[.measure]") {
  World world({.delay = kMs});
  world.start(1);
  const Address from = stranger(1);
  world.watch(from);
  Dice dice(4);
  Bytes hello;
  encode({.type = HandshakeType::Hello, .nonce = dice.next()}, hello);
  world.node(1).on_datagram(hello, from, world.now);
  world.run(2 * kMs);
  const auto challenge = decode_handshake(world.arrived(address_of(1), from).front());
  std::vector<std::uint8_t> noise(258);
  for (auto& byte : noise) byte = static_cast<std::uint8_t>(dice.next());
  Bytes proof;
  encode({.type = HandshakeType::Initiate,
          .nonce = challenge->nonce,
          .cookie = challenge->cookie,
          .noise = noise},
         proof);
  Bytes junk = proof;
  junk[20] ^= std::byte{1};
  for (const auto& [name, datagram] :
       {std::pair("question", hello), std::pair("proof, bad cookie", junk),
        std::pair("proof, good cookie, no key", proof)}) {
    constexpr int kTimes = 20'000;
    const double start = tandem::pbd::thread_cpu_seconds();
    for (int i = 0; i < kTimes; ++i) world.node(1).on_datagram(datagram, from, world.now);
    std::printf("%s: %.2f us\n", name, 1e6 * (tandem::pbd::thread_cpu_seconds() - start) / kTimes);
    (void)world.arrived(address_of(1), from);
  }
}

}  // namespace flood_test
