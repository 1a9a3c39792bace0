// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/events.h"

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "stub_transport.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/random.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus::events_test {

using testing::StubTransport;

constexpr SessionTime kStep = 16'666'667;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}
std::string text_of(const Event& event) {
  return {reinterpret_cast<const char*>(event.payload.data()), event.payload.size()};
}

/// Members of one virtual network, which are polled in turn.
struct Session {
  explicit Session(const LinkOptions& link, int count = 2, const EventOptions& options = {})
      : network(link, 7) {
    for (int i = 0; i < count; ++i) join(options);
  }
  void join(const EventOptions& options = {}) {
    const PeerId id = channels.size() + 1;
    channels.push_back(std::make_unique<EventChannel>(network.transport(id), options));
    heard.emplace_back();
  }
  /// Make steps; `before(i)` in each of them, before the polls.
  template <class Before>
  void run(int steps, Before&& before) {
    for (int i = 0; i < steps; ++i) {
      before(i);
      network.advance_to(network.now() + kStep);
      for (std::size_t k = 0; k < channels.size(); ++k) {
        std::vector<Packet> rest;
        channels[k]->poll(network.now());
        channels[k]->drain(rest);
        for (const Event& event : channels[k]->received()) heard[k].push_back(event);
      }
    }
  }
  void run(int steps) {
    run(steps, [](int) {});
  }
  EventChannel& at(std::size_t k) { return *channels[k]; }
  std::vector<std::string> texts(std::size_t k, PeerId from) const {
    std::vector<std::string> texts;
    for (const Event& event : heard[k]) {
      if (event.from == from) texts.push_back(text_of(event));
    }
    return texts;
  }

  VirtualNetwork network;
  std::vector<std::unique_ptr<EventChannel>> channels;
  std::vector<std::vector<Event>> heard;
};

LinkOptions bad_link() {
  return {.latency = 0.12, .jitter = 0.03, .loss = 0.3, .duplicate = 0.2, .reorder = 0.2};
}

TEST_CASE("events: each comes once, in the order of its sender, over a bad link",
          "[consensus][events]") {
  Session session(bad_link(), 3);
  session.run(2);
  std::map<PeerId, std::vector<std::string>> sent;
  pbd::SplitMix64 random(5);
  session.run(600, [&](int i) {
    // Cut for five seconds in the middle, and for good until a new handshake.
    if (i == 200) session.network.cut(1, 2);
    if (i == 500) session.network.heal(1, 2);
    if (i == 250) session.network.transport(3).drop(1, "test");
    if (i == 400) {
      session.network.heal(1, 3);
      session.network.heal(3, 1);
    }
    for (PeerId from = 1; from <= 3; ++from) {
      if (random.next() % 4 != 0) continue;
      const std::string text =
          std::to_string(from) + "/" + std::to_string(i) + std::string(random.next() % 3000, 'x');
      CHECK(session.at(from - 1).send("test", bytes_of(text)) == 2);
      sent[from].push_back(text);
    }
  });
  session.run(900);
  for (std::size_t k = 0; k < 3; ++k) {
    for (PeerId from = 1; from <= 3; ++from) {
      if (from == k + 1) continue;
      CAPTURE(k, from);
      CHECK(session.texts(k, from) == sent[from]);
    }
    CHECK(session.at(k).lost() == 0);
    CHECK(session.at(k).rejected() == 0);
  }
}

TEST_CASE("events: topic, time, sender and one receiver", "[consensus][events]") {
  Session session({.latency = 0.05}, 3);
  session.run(1);
  const SessionTime sent = session.network.now();
  CHECK(session.at(0).send("door/open", bytes_of("7"), 3) == 1);
  CHECK(session.at(0).send("door/shut", {}, 9) == 0);  // nobody has that id
  session.run(10);
  CHECK(session.heard[1].empty());
  REQUIRE(session.heard[2].size() == 1);
  const Event& event = session.heard[2].front();
  CHECK(event.from == 1);
  CHECK(event.topic == "door/open");
  CHECK(text_of(event) == "7");
  CHECK(event.stamp == sent);
  CHECK(event.role == Role::Share);
}

TEST_CASE("events: a late member hears later events", "[consensus][events]") {
  Session session({.latency = 0.02});
  session.run(2);
  session.at(0).send("early", {});
  session.run(20);
  session.join();
  session.run(2);
  session.at(0).send("late", {});
  session.run(20);
  REQUIRE(session.heard[2].size() == 1);
  CHECK(session.heard[2].front().topic == "late");
  CHECK(session.heard[1].size() == 2);
}

TEST_CASE("events: a peer that is away loses and counts the excess, and gets the rest",
          "[consensus][events]") {
  Session session({.latency = 0.02}, 2, {.kept_bytes = 4096});
  session.run(2);
  session.at(0).send("n", bytes_of("first"));
  session.run(10);
  session.network.cut(1, 2);
  session.network.cut(2, 1);
  session.run(1);
  for (int i = 0; i < 100; ++i) session.at(0).send("n", bytes_of(std::to_string(i)));
  const std::uint64_t lost = session.at(0).lost();
  CHECK(lost > 20);
  session.run(5);
  session.network.heal(1, 2);
  session.network.heal(2, 1);
  session.run(60);
  const std::vector<std::string> came = session.texts(1, 1);
  REQUIRE(came.size() == 1 + 100 - lost);
  CHECK(came[0] == "first");
  CHECK(came[1] == std::to_string(lost));
  CHECK(came.back() == "99");
  CHECK(session.at(1).lost() == lost);
}

TEST_CASE("events: a member that is away for too long begins anew", "[consensus][events]") {
  Session session({.latency = 0.02}, 2, {.absence = 1.0});
  session.run(2);
  session.network.cut(1, 2);
  session.network.cut(2, 1);
  session.run(2);
  CHECK(session.at(0).send("while away", {}) == 1);
  session.run(70);
  CHECK(session.at(0).send("gone", {}) == 0);
  session.network.heal(1, 2);
  session.network.heal(2, 1);
  session.run(3);
  session.at(0).send("back", {});
  session.run(30);
  REQUIRE(session.heard[1].size() == 1);
  CHECK(session.heard[1].front().topic == "back");
}

TEST_CASE("events: a member's budget holds back events and loses none", "[consensus][events]") {
  constexpr double kBudget = 20'000.0;
  Session session({.latency = 0.01}, 2, {.bytes_per_s = kBudget});
  session.run(2);
  const std::string payload(1000, 'x');
  for (int i = 0; i < 200; ++i) session.at(0).send("flood", bytes_of(payload));
  session.run(60);
  // At once what a second has, and in the first second as much again; one may go over it.
  CHECK(static_cast<double>(session.heard[1].size() * payload.size()) <= 2.0 * kBudget + 2000.0);
  CHECK(session.heard[1].size() > 10);
  session.run(900);
  CHECK(session.heard[1].size() == 200);
}

TEST_CASE("events: invalid events are refused by name", "[consensus][events][fault]") {
  Session session({});
  const std::vector<std::byte> long_payload(kMaxPacketBytes);
  using tandem::testing::refusal;
  CHECK(refusal([&] { session.at(0).send(std::string(65, 't'), {}); }).find("topic") !=
        std::string::npos);
  CHECK(refusal([&] { session.at(0).send("t", long_payload); }).find("payload") !=
        std::string::npos);
  StubTransport stub(1);
  CHECK(refusal([&] { EventChannel(stub, {.resend = 0.0}); }).find("resend") != std::string::npos);
  CHECK(refusal([&] { EventChannel(stub, {.kept_bytes = 1}); }).find("kept_bytes") !=
        std::string::npos);
  CHECK(refusal([&] { EventChannel(stub, {.bytes_per_s = 0.0}); }).find("bytes_per_s") !=
        std::string::npos);
  CHECK(refusal([&] { EventChannel(stub, {.absence = -1.0}); }).find("absence") !=
        std::string::npos);
}

/// Packets that a member sends in one poll.
std::vector<std::vector<std::byte>> packets_of(EventChannel& channel, StubTransport& wire) {
  wire.posted.clear();
  channel.poll(kStep);
  return wire.posted;
}

TEST_CASE("events: damaged packets are counted and change nothing", "[consensus][events][fault]") {
  StubTransport sender_wire(1);
  sender_wire.known = {{.id = 2, .connected = true}};
  EventChannel sender(sender_wire);
  sender.poll(0);
  sender.send("topic", bytes_of("payload"));
  const auto packets = packets_of(sender, sender_wire);
  REQUIRE(packets.size() == 1);

  pbd::SplitMix64 random(11);
  std::uint64_t delivered = 0;
  for (int i = 0; i < 20'000; ++i) {
    StubTransport wire(2);
    wire.known = {{.id = 1, .connected = true}, {.id = 3, .connected = true}};
    EventChannel channel(wire);
    channel.poll(0);
    channel.send("own", bytes_of("kept"));
    std::vector<std::byte> packet = packets.front();
    const std::size_t damages = 1 + random.next() % 3;
    for (std::size_t k = 0; k < damages; ++k) {
      packet[random.next() % packet.size()] = static_cast<std::byte>(random.next());
    }
    if (random.next() % 4 == 0) packet.resize(random.next() % packet.size());
    wire.inbox.push_back({1, packet});
    channel.poll(kStep);
    REQUIRE(channel.received().size() <= 1);
    delivered += channel.received().size();
    // Another member is heard all the same.
    wire.inbox.push_back({3, packets.front()});
    channel.poll(2 * kStep);
    REQUIRE(channel.received().size() == 1);
    REQUIRE(text_of(channel.received().front()) == "payload");
  }
  CHECK(delivered > 1000);  // those whose damage is to the text
  CHECK(delivered < 19'000);
}

TEST_CASE("events: acknowledgements of unsent events are ignored", "[consensus][events][fault]") {
  Session session({.latency = 0.02});
  session.run(2);
  // The second member acknowledges for others' lists, too early and again.
  pbd::SplitMix64 random(3);
  for (int i = 0; i < 50; ++i) {
    session.at(0).send("n", bytes_of(std::to_string(i)));
    std::vector<std::byte> forged = {std::byte{0x45}, std::byte{0x56}, std::byte{1}, std::byte{2}};
    for (int k = 0; k < 2; ++k) {
      const std::uint64_t value = random.next() % 8 == 0 ? random.next() % 64 : random.next();
      for (int b = 0; b < 8; ++b) forged.push_back(static_cast<std::byte>(value >> (8 * b)));
    }
    session.at(1).post(1, forged, Delivery::Newest);
    session.run(1);
  }
  session.run(60);
  CHECK(session.heard[1].size() == 50);
}

TEST_CASE("events: peers share a body through channels as they do without", "[consensus][events]") {
  const auto shared_run = [](bool with_channels) {
    VirtualNetwork network({.latency = 0.03, .loss = 0.1}, 9);
    std::vector<std::unique_ptr<EventChannel>> channels;
    std::vector<std::unique_ptr<pbd::World>> worlds;
    std::vector<std::unique_ptr<Peer>> peers;
    for (PeerId id = 1; id <= 2; ++id) {
      Transport* wire = &network.transport(id);
      if (with_channels) {
        channels.push_back(std::make_unique<EventChannel>(*wire));
        wire = channels.back().get();
      }
      worlds.push_back(std::make_unique<pbd::World>());
      pbd::BodyDef def;
      def.pose.position.x() = 0.01 * static_cast<double>(id);
      const pbd::BodyId body = worlds.back()->add_body(def);
      peers.push_back(std::make_unique<Peer>(*worlds.back(), *wire));
      peers.back()->share({.id = SharedId::from_name("body"), .body = body});
    }
    pbd::Solver solver;
    for (SessionTime now = kStep; now < 120 * kStep; now += kStep) {
      network.advance_to(now);
      for (std::size_t k = 0; k < 2; ++k) {
        if (with_channels) channels[k]->poll(now);
        peers[k]->before_step(now);
        solver.step(*worlds[k], 1.0 / 60.0);
        peers[k]->after_step(now + kStep);
      }
    }
    return std::pair(worlds[0]->hash(), worlds[1]->hash());
  };
  CHECK(shared_run(true) == shared_run(false));
}

}  // namespace tandem::consensus::events_test
