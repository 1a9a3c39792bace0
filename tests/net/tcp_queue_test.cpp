// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bounded queues, and Reliable over broken connections.
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "raw_peer.h"
#include "support/catch.h"
#include "tandem/net/tcp.h"

namespace tcp_queue_test {

using namespace tandem::net;
using raw::connected;
using raw::eventually;
using raw::linked;
using raw::operator+;
using raw::options;
using raw::status;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;

namespace {

constexpr std::size_t kFrame = 1000;

/// A state with its number in front.
raw::Bytes numbered(std::uint64_t number) {
  raw::Bytes out = raw::le(number, 8);
  out.resize(kFrame);
  return out;
}

/// Small everywhere, so that a peer which does not read is felt soon.
TcpOptions tight(PeerId self) {
  TcpOptions out = options(self);
  out.max_message_bytes = 1024;
  out.send_queue_bytes = 20 * 1024;
  out.receive_queue_bytes = 20 * 1024;
  out.socket_buffer_bytes = 4096;
  return out;
}

}  // namespace

TEST_CASE("tcp: a full send queue drops the oldest states and counts them", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tight(1));
  raw::Socket slow = raw::Socket::connect(a.local_port(), 4096);
  raw::join(slow, {.peer = 2});
  REQUIRE(eventually([&] { return connected(a, 2); }));

  // Until well over the queue has been dropped: neither the kernel nor anyone else takes more.
  std::uint64_t posted = 0;
  while (status(a, 2).dropped_queue_full < 100) {
    REQUIRE(a.post(2, numbered(posted++), Delivery::Newest));
    REQUIRE(posted < 100'000);
  }
  REQUIRE(a.post(2, numbered(posted++), Delivery::Reliable));
  REQUIRE(connected(a, 2));

  // All that comes out is in order, the newest is there, and what is missing was counted.
  std::uint64_t last = 0, seen = 0;
  while (last + 1 < posted) {
    const auto frame = slow.read();
    REQUIRE(frame);
    if (frame->type != raw::kNewest && frame->type != raw::kReliable) continue;
    const std::size_t skip = frame->type == raw::kReliable ? 8 : 0;
    REQUIRE(frame->payload.size() == kFrame + skip);
    const std::uint64_t number = raw::number(std::span(frame->payload).subspan(skip, 8));
    if (seen > 0) REQUIRE(number > last);
    last = number;
    ++seen;
  }
  CHECK(seen + status(a, 2).dropped_queue_full == posted);
  CHECK(status(a, 2).packets_out == seen);
}

TEST_CASE("tcp: reliable frames that do not fit cut the connection with a reason",
          "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tight(1));
  raw::Socket slow = raw::Socket::connect(a.local_port(), 4096);
  raw::join(slow, {.peer = 2});
  REQUIRE(eventually([&] { return connected(a, 2); }));
  std::uint64_t posted = 0;
  while (a.post(2, numbered(posted), Delivery::Reliable)) REQUIRE(++posted < 100'000);
  // Not acknowledged is not gone: 20 KiB hold 19 frames of 1000 bytes and their overhead.
  CHECK(posted == 20 * 1024 / (kFrame + 64));
  CHECK_FALSE(connected(a, 2));
  CHECK(status(a, 2).reason.find("send queue full") != std::string::npos);
  const auto goodbye = slow.read(raw::kGoodbye);
  REQUIRE(goodbye);
  CHECK(raw::as_text(goodbye->payload) == "does not keep up");
  slow.close();

  // The same process comes back and gets them all, from the first.
  raw::Socket again = raw::Socket::connect(a.local_port());
  raw::join(again, {.peer = 2});
  for (std::uint64_t i = 0; i < posted; ++i) {
    const auto frame = again.read(raw::kReliable);
    REQUIRE(frame);
    CHECK(raw::number(std::span(frame->payload).first(8)) == i + 1);
    CHECK(raw::number(std::span(frame->payload).subspan(8, 8)) == i);
  }
}

TEST_CASE("tcp: states make room for reliable frames", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tight(1));
  raw::Socket slow = raw::Socket::connect(a.local_port(), 4096);
  raw::join(slow, {.peer = 2});
  REQUIRE(eventually([&] { return connected(a, 2); }));
  // Until the socket takes nothing any more: each state then pushes one out of the queue, ten times
  // in a row with time for the socket between them.
  std::uint64_t posted = 0;
  for (int in_a_row = 0; in_a_row < 10;) {
    const std::uint64_t before = status(a, 2).dropped_queue_full;
    REQUIRE(a.post(2, numbered(posted++), Delivery::Newest));
    REQUIRE(posted < 100'000);
    const bool pushed = status(a, 2).dropped_queue_full == before + 1;
    in_a_row = pushed ? in_a_row + 1 : 0;
    if (pushed) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::uint64_t dropped = status(a, 2).dropped_queue_full;
  // One less than fit: all states but one or two, for one may be on its way, have to go.
  for (int i = 0; i < 18; ++i) REQUIRE(a.post(2, numbered(1000), Delivery::Reliable));
  CHECK(connected(a, 2));
  CHECK(status(a, 2).dropped_queue_full >= dropped + 16);
}

TEST_CASE("tcp: an inbox that is not drained keeps the newest states", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tight(1));
  raw::Socket flood = raw::Socket::connect(a.local_port());
  raw::join(flood, {.peer = 2});
  constexpr std::uint64_t kCount = 500;
  for (std::uint64_t i = 0; i < kCount; ++i) {
    REQUIRE(flood.send(raw::frame(raw::kNewest, numbered(i))));
  }
  REQUIRE(eventually([&] { return status(a, 2).packets_in == kCount; }));
  std::vector<Packet> got;
  a.drain(got);
  const std::uint64_t kept = 20 * 1024 / (kFrame + 64);
  REQUIRE(got.size() == kept);
  for (std::uint64_t i = 0; i < kept; ++i) {
    CHECK(raw::number(std::span(got[i].bytes).first(8)) == kCount - kept + i);
  }
  CHECK(status(a, 2).dropped_queue_full == kCount - kept);
}

TEST_CASE("tcp: an inbox full of reliable frames loses none of them", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tight(1));
  TcpOptions roomy = options(2, {a.local_port()});
  TcpTransport b(roomy);
  REQUIRE(eventually([&] { return linked(a, b); }));
  constexpr std::uint64_t kCount = 60;  // three times what the inbox holds
  for (std::uint64_t i = 0; i < kCount; ++i) {
    REQUIRE(eventually([&] { return b.post(1, numbered(i), Delivery::Reliable); }));
  }
  CHECK(eventually(
      [&] { return status(a, 2).reason.find("receive queue full") != std::string::npos; }));
  const std::vector<Packet> got = raw::receive(a, kCount);
  REQUIRE(got.size() == kCount);
  for (std::uint64_t i = 0; i < kCount; ++i) {
    CHECK(raw::number(std::span(got[i].bytes).first(8)) == i);
  }
}

TEST_CASE("tcp: reliable frames lost with a connection are sent again", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  const PeerId peer = GENERATE(as<PeerId>{}, 2, 5);
  CAPTURE(peer);
  const raw::Greeting greeting{.peer = peer, .incarnation = 77};
  {
    raw::Socket first = raw::Socket::connect(a.local_port());
    raw::join(first, greeting);
    REQUIRE(eventually([&] { return connected(a, peer); }));
    for (std::uint64_t i = 1; i <= 5; ++i) {
      REQUIRE(a.post(peer, raw::le(i, 8), Delivery::Reliable));
    }
    for (int i = 0; i < 5; ++i) REQUIRE(first.read(raw::kReliable));
    REQUIRE(first.send(raw::frame(raw::kAck, raw::le(2, 8))));
    // This end sends two, the transport acknowledges them.
    REQUIRE(first.send(raw::frame(raw::kReliable, raw::le(1, 8) + raw::text("one"))));
    REQUIRE(first.send(raw::frame(raw::kReliable, raw::le(2, 8) + raw::text("two"))));
    for (std::uint64_t acked = 0; acked < 2;) {
      const auto ack = first.read(raw::kAck);
      REQUIRE(ack);
      acked = raw::number(ack->payload);
    }
    first.reset();
  }
  REQUIRE(eventually([&] { return !connected(a, peer); }));
  CHECK_FALSE(status(a, peer).reason.empty());
  {
    raw::Socket second = raw::Socket::connect(a.local_port());
    const raw::Joined joined = raw::join(second, greeting, 3);
    CHECK(joined.received == 2);
    for (std::uint64_t i = 4; i <= 5; ++i) {  // 3 had come although it was not acknowledged
      const auto frame = second.read(raw::kReliable);
      REQUIRE(frame);
      CHECK(raw::number(std::span(frame->payload).first(8)) == i);
      CHECK(raw::number(std::span(frame->payload).subspan(8)) == i);
    }
    // Two again, then three: taken once.
    REQUIRE(second.send(raw::frame(raw::kReliable, raw::le(2, 8) + raw::text("two"))));
    REQUIRE(second.send(raw::frame(raw::kReliable, raw::le(3, 8) + raw::text("three"))));
    const std::vector<Packet> got = raw::receive(a, 3);
    REQUIRE(got.size() == 3);
    CHECK(raw::as_text(got[0].bytes) == "one");
    CHECK(raw::as_text(got[1].bytes) == "two");
    CHECK(raw::as_text(got[2].bytes) == "three");
  }
  // Another process of that id starts from nothing.
  raw::Socket third = raw::Socket::connect(a.local_port());
  raw::Greeting restarted = greeting;
  restarted.incarnation = 78;
  CHECK(raw::join(third, restarted).received == 0);
  REQUIRE(eventually([&] { return a.incarnation(peer) == 78; }));
  REQUIRE(a.post(peer, raw::text("x"), Delivery::Reliable));
  const auto frame = third.read(raw::kReliable);
  REQUIRE(frame);
  CHECK(raw::number(std::span(frame->payload).first(8)) == 1);
}

TEST_CASE("tcp: reliable messages leave before the end", "[net][socket]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  constexpr std::uint64_t kCount = 200;
  {
    TcpOptions patient = options(2, {a.local_port()});
    patient.flush_timeout = std::chrono::milliseconds(10000);
    TcpTransport b(patient);
    REQUIRE(eventually([&] { return linked(a, b); }));
    for (std::uint64_t i = 0; i < kCount; ++i) {
      REQUIRE(b.post(1, raw::le(i, 8), Delivery::Reliable));
    }
  }
  const std::vector<Packet> got = raw::receive(a, kCount);
  CHECK(got.size() == kCount);
  CHECK(eventually([&] { return status(a, 2).reason == "peer: has left"; }));
}

// Windows ends a send that waits when its socket is closed; wine 8 never does.
TEST_CASE("tcp: the end does not wait for a peer that hangs", "[net][socket][not_on_wine]") {
  const raw::LeakCheck leaks;
  auto a = std::make_unique<TcpTransport>(tight(1));
  raw::Socket hung = raw::Socket::connect(a->local_port(), 4096);
  raw::join(hung, {.peer = 2});
  REQUIRE(eventually([&] { return connected(*a, 2); }));
  for (std::uint64_t i = 0; i < 19; ++i) REQUIRE(a->post(2, numbered(i), Delivery::Reliable));
  raw::Socket mute = raw::Socket::connect(a->local_port());
  const auto start = std::chrono::steady_clock::now();
  a.reset();
  // The limit tells a hang (the socket would be read by nobody, ever) from flush_timeout, 250 ms.
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(10));
}

}  // namespace tcp_queue_test
