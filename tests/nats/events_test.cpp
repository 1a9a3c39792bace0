// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What happens at a place comes once to all who are near, whatever becomes of the server.
#include <atomic>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include "cell_wire.h"
#include "event_store.h"
#include "nats/peers.h"
#include "support/bodies.h"
#include "tandem/nats/cell_events.h"

namespace tandem::nats::events_test {
namespace {

using namespace testing;
using tandem::testing::names;
using tandem::testing::refusal;

CellEventOptions event_options(std::uint16_t port, PeerId self) {
  CellEventOptions out;
  out.hub = std::make_shared<NatsHub>(HubOptions{.servers = {{"127.0.0.1", port}}});
  out.scene_hash = 42;
  out.session_key = session_key();
  out.cells = {.edge = 4.0, .levels = 3, .near = 4.0, .slack = 0.5};
  out.self = self;
  return out;
}

/// By sender and cell, the numbers in the order in which they came.
using Heard = std::map<std::pair<PeerId, Cell>, std::vector<std::uint64_t>>;

std::size_t hear(CellEvents& events, Heard& heard) {
  std::vector<CellEvent> all;
  events.take(all);
  for (const CellEvent& each : all) {
    CHECK(each.topic == "door");
    heard[{each.from, each.cell}].push_back(number_of({.from = each.from, .bytes = each.payload}));
  }
  return all.size();
}

TEST_CASE("events in cells: events not taken yet wait at the server, and none is lost", "[nats]") {
  if (!has_server()) return;
  Server server;
  CellEvents first(event_options(server.port(), 1));
  CellEvents second(event_options(server.port(), 2));
  CellEvents listener(event_options(server.port(), 3));
  listener.set_position(Vec3(1.0, 1.0, 0.0));
  constexpr std::uint64_t kEach = 700;
  Heard expected;
  for (std::uint64_t i = 0; i < kEach; ++i) {
    const Vec3 at(i % 2 == 0 ? 1.0 : 6.0, 1.0, 0.0);
    for (CellEvents* sender : {&first, &second}) {
      REQUIRE(sender->send(at, "door", numbered(i), 7));
    }
    for (const PeerId from : {1, 2}) expected[{from, Cell{0, i % 2 == 0 ? 0 : 1, 0}}].push_back(i);
  }
  REQUIRE(eventually([&] { return first.waiting() + second.waiting() + listener.waiting() == 0; },
                     std::chrono::seconds(30)));
  Heard heard;
  std::size_t count = hear(listener, heard);
  CHECK(count == CellEvents::kMaxUntaken);
  REQUIRE(eventually([&] { return (count += hear(listener, heard)) >= 2 * kEach; }));
  CHECK(heard == expected);
}

TEST_CASE("events in cells: peers within reach, later ones too, hear each once and in order",
          "[nats]") {
  if (!has_server()) return;
  Server server;
  CellEvents first(event_options(server.port(), 1));
  CellEvents second(event_options(server.port(), 2));
  CellEvents far(event_options(server.port(), 3));
  second.set_position(Vec3(5.0, 1.0, 0.0));
  far.set_position(Vec3(100.0, 1.0, 0.0));
  for (std::uint64_t i = 0; i < 50; ++i) {
    REQUIRE(first.send(Vec3(i % 2 == 0 ? 1.0 : 6.0, 1.0, 0.0), "door", numbered(i), 7));
  }
  Heard expected;
  for (std::uint64_t i = 0; i < 50; ++i) {
    expected[{1, Cell{0, i % 2 == 0 ? 0 : 1, 0}}].push_back(i);
  }
  Heard heard;
  std::size_t count = 0;
  REQUIRE(eventually([&] { return (count += hear(second, heard)) >= 50; }));
  CHECK(heard == expected);
  CHECK(hear(far, heard) == 0);
  // He goes away and comes back: what he has heard is not said again.
  second.set_position(Vec3(100.0, 1.0, 0.0));
  REQUIRE(first.send(Vec3(1.0, 1.0, 0.0), "door", numbered(50), 7));
  REQUIRE(eventually([&] { return first.waiting() == 0; }));
  second.set_position(Vec3(5.0, 1.0, 0.0));
  far.set_position(Vec3(5.0, 1.0, 0.0));
  expected[{1, Cell{0, 0, 0}}].push_back(50);
  Heard later;
  std::size_t more = 0;
  REQUIRE(eventually([&] {
    more += hear(far, later);
    count += hear(second, heard);
    return more >= 51 && count >= 51;
  }));
  CHECK(heard == expected);
  CHECK(later == expected);
}

TEST_CASE("events in cells: none is lost or doubled though a killed server loses records",
          "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  std::vector<std::unique_ptr<CellEvents>> all;
  std::vector<Heard> heard(3);
  for (PeerId id = 1; id <= 3; ++id) {
    all.push_back(std::make_unique<CellEvents>(event_options(server.port(), id)));
    all.back()->set_position(Vec3(1.0, 1.0, 0.0));
  }
  std::uint64_t next = 0;
  const auto run = [&](int count) {
    for (int i = 0; i < count; ++i, ++next) {
      for (std::size_t k = 0; k < all.size(); ++k) {
        REQUIRE(all[k]->send(Vec3(1.0, 1.0, 0.0), "door", numbered(next), 7));
        hear(*all[k], heard[k]);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  };
  const auto complete = [&] {
    bool out = true;
    for (std::size_t k = 0; k < all.size(); ++k) {
      hear(*all[k], heard[k]);
      for (PeerId from = 1; from <= 3; ++from) {
        out = out && heard[k][{from, Cell{0, 0, 0}}].size() >= next;
      }
    }
    return out;
  };
  run(60);
  server.kill();
  run(60);  // there is none
  server.start();
  run(60);
  server.keep();  // stopped in order, and started
  run(60);
  REQUIRE(eventually(complete, std::chrono::seconds(30)));
  run(30);
  server.lose();  // all since keep()
  server.start();
  REQUIRE(eventually(complete, std::chrono::seconds(30)));
  // Somebody who comes only now hears of all that is kept.
  all.push_back(std::make_unique<CellEvents>(event_options(server.port(), 4)));
  heard.emplace_back();
  all.back()->set_position(Vec3(1.0, 1.0, 0.0));
  REQUIRE(eventually(complete, std::chrono::seconds(30)));
  std::vector<std::uint64_t> expected(next);
  for (std::size_t i = 0; i < expected.size(); ++i) expected[i] = i;
  for (const Heard& each : heard) {
    CHECK(each.size() == 3);
    for (const auto& [who, numbers] : each) CHECK(numbers == expected);
  }
}

TEST_CASE("events in cells: strangers' and other cells' messages are counted and dropped",
          "[nats][fault]") {
  if (!has_server()) return;
  Server server;
  CellEvents near(event_options(server.port(), 1));
  CellEvents far(event_options(server.port(), 2));
  near.set_position(Vec3(1.0, 1.0, 0.0));
  NatsHub stranger(HubOptions{.servers = {{"127.0.0.1", server.port()}}});
  const Subjects subjects("tandem", 42, event_options(server.port(), 3).cells);
  const std::string here = subjects.base() + "ev." + subjects.path({0, 0, 0});
  std::atomic<int> copied = 0;
  const auto copies = stranger.impl().subscribe(subjects.base() + "ev." + subjects.path({0, 50, 0}),
                                                [&](std::span<const std::byte> bytes) {
                                                  stranger.impl().publish(here, bytes);
                                                  ++copied;
                                                });
  REQUIRE(eventually([&] { return stranger.status().connected; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  Heard heard;
  REQUIRE(far.send(Vec3(1.0, 1.0, 0.0), "door", numbered(1), 7));  // makes the stream
  REQUIRE(eventually([&] { return hear(near, heard) == 1; }));
  for (std::size_t length = 0; length < 100; ++length) {
    stranger.impl().publish(here, std::vector<std::byte>(length, std::byte{1}));
  }
  REQUIRE(far.send(Vec3(201.0, 1.0, 0.0), "door", numbered(2), 7));
  REQUIRE(eventually([&] { return copied == 1; }));
  REQUIRE(far.send(Vec3(1.0, 1.0, 0.0), "door", numbered(3), 7));
  REQUIRE(eventually([&] {
    hear(near, heard);
    return near.refused() == 101 && heard[{2, Cell{0, 0, 0}}].size() == 2;
  }));
  CHECK(heard == Heard{{{2, Cell{0, 0, 0}}, {1, 3}}});
}

TEST_CASE("events in cells: bytes that are no event are refused, and numbers of a source only grow",
          "[nats][fault]") {
  NumberedEvent event{.source = 5, .number = 3, .event = {}};
  event.event = {
      .cell = {0, 3, -4}, .from = 1, .stamp = 9, .topic = "door", .payload = numbered(1)};
  std::vector<std::byte> bytes;
  encode(event, bytes);
  const auto decoded = decode_event(bytes);
  REQUIRE(decoded.has_value());
  CHECK(decoded->source == 5);
  CHECK(decoded->event.cell == event.event.cell);
  CHECK(decoded->event.topic == "door");
  CHECK(decoded->event.payload == event.event.payload);
  constexpr std::size_t kHead = 1 + 8 + 8 + 4 + 4 + 8 + 1 + 4;
  for (std::size_t i = 0; i < kHead; ++i) {
    CHECK_FALSE(decode_event(std::span(bytes).first(i)).has_value());
  }
  bytes.resize(kHead + CellEvents::kMaxPayloadBytes + 1);
  CHECK_FALSE(decode_event(bytes).has_value());
  bytes.clear();
  encode(Presence{.sent = 5, .position = Vec3::Zero(), .hears = 8.0}, bytes);
  CHECK_FALSE(decode_event(bytes).has_value());  // under the same key
  EventLog log;
  CHECK(log.is_new(event));
  CHECK_FALSE(log.is_new(event));
  event.number = 2;
  CHECK_FALSE(log.is_new(event));
  event.number = 4;
  CHECK(log.is_new(event));
  for (event.source = 100; event.source < 3000; ++event.source) CHECK(log.is_new(event));
}

TEST_CASE("events in cells: invalid events are refused by name", "[nats][fault]") {
  CellEventOptions options = event_options(4222, 1);
  options.self = 0;
  CHECK(names(refusal([&] { options.validate(); }), "self", "0", "not 0"));
  options = event_options(4222, 1);
  options.kept = std::chrono::seconds(0);
  CHECK(names(refusal([&] { options.validate(); }), "kept", "0", "1 day"));
  options = event_options(4222, 1);
  options.prefix = "a.b";
  CHECK(names(refusal([&] { options.validate(); }), "prefix", "a.b", "letters"));
  CellEvents events(event_options(4222, 1));
  const std::string topic(CellEvents::kMaxTopicBytes + 1, 'a');
  CHECK_FALSE(events.send(Vec3::Zero(), topic, {}, 0));
  const std::vector<std::byte> payload(CellEvents::kMaxPayloadBytes + 1);
  CHECK_FALSE(events.send(Vec3::Zero(), "door", payload, 0));
}

}  // namespace
}  // namespace tandem::nats::events_test
