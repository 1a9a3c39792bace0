// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Streams from strangers and from peers gone bad.
#include <random>
#include <string>
#include <vector>

#include "raw_peer.h"
#include "support/catch.h"
#include "tandem/net/tcp.h"

namespace tcp_fault_test {

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

/// A peer that is well still gets in and through.
void check_alive(TcpTransport& a) {
  TcpTransport b(options(1000, {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  REQUIRE(b.post(a.self(), raw::text("alive"), Delivery::Reliable));
  const std::vector<Packet> got = raw::receive(a, 1);
  REQUIRE_FALSE(got.empty());
  CHECK(raw::as_text(got.back().bytes) == "alive");
}

}  // namespace

TEST_CASE("tcp: another protocol version is refused by the listener", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  raw::Socket old = raw::Socket::connect(a.local_port());
  REQUIRE(old.send(raw::hello({.peer = 2, .version = 7})));
  const auto hello = old.read(raw::kHello);  // it says who refuses
  REQUIRE(hello);
  CHECK(raw::number(std::span(hello->payload).subspan(6, 8)) == 1);
  const auto goodbye = old.read(raw::kGoodbye);
  REQUIRE(goodbye);
  CHECK(raw::as_text(goodbye->payload) == "protocol version 7 differs from 1");
  CHECK(eventually([&] { return a.strangers().refused == 1; }));
  CHECK(status(a, 2).reason == "protocol version 7 differs from 1");
  CHECK(status(a, 2).rejected == 1);
  CHECK_FALSE(connected(a, 2));
}

TEST_CASE("tcp: another protocol version is refused by the dialler", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  raw::Listener there;
  TcpTransport a(options(1, {there.port()}));
  raw::Socket peer = there.accept();
  REQUIRE(peer.read(raw::kHello));
  REQUIRE(peer.send(raw::hello({.peer = 2, .version = 7})));
  const auto goodbye = peer.read(raw::kGoodbye);
  REQUIRE(goodbye);
  CHECK(raw::as_text(goodbye->payload) == "protocol version 7 differs from 1");
  peer.close();
  CHECK(eventually([&] { return status(a, 2).reason == "protocol version 7 differs from 1"; }));
  CHECK(eventually([&] {
    return !a.dials().empty() && a.dials()[0].reason == "protocol version 7 differs from 1";
  }));
}

TEST_CASE("tcp: a refusal's text is cut and cleaned", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  raw::Listener there;
  TcpTransport a(options(1, {there.port()}));
  raw::Socket peer = there.accept();
  REQUIRE(peer.read(raw::kHello));
  REQUIRE(peer.send(raw::frame(raw::kGoodbye, raw::text("\x1b[2Jno\n" + std::string(1000, 'x')))));
  CHECK(eventually([&] { return a.dials()[0].reason == "peer: ?[2Jno?" + std::string(249, 'x'); }));
}

TEST_CASE("tcp: streams that are no handshake are counted and closed", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  const raw::Bytes good = raw::hello({.peer = 2});
  const std::vector<raw::Bytes> streams = {
      raw::le(0, 4),                                                // no length
      raw::le(0xffffffff, 4),                                       // 4 GiB
      raw::le(4098, 4) + raw::le(1, 1),                             // a byte above the limit
      raw::text("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"),       // another protocol
      raw::frame(raw::kHello, raw::text("XXXX")),                   // not the magic
      raw::frame(raw::kHello, {}),                                  // empty
      raw::frame(raw::kHello, {good.begin() + 5, good.end() - 1}),  // a byte short
      raw::frame(raw::kHello,
                 raw::Bytes(good.begin() + 5, good.end()) + raw::le(0, 1)),  // one too many
      raw::hello({.peer = 0}),                                               // no id
      raw::hello({.peer = 2, .incarnation = 0}),
      raw::welcome(1, 0),                       // out of order
      raw::frame(raw::kNewest, raw::le(1, 8)),  // before the handshake
      raw::frame(raw::kAck, raw::le(1, 8)),
      raw::frame(200, raw::le(1, 8)),  // no such type
  };
  for (std::size_t i = 0; i < streams.size(); ++i) {
    CAPTURE(i);
    raw::Socket stranger = raw::Socket::connect(a.local_port());
    REQUIRE(stranger.send(streams[i]));
    CHECK(stranger.ends());
    CHECK(eventually([&] { return a.strangers().malformed == i + 1; }));
    CHECK_FALSE(a.strangers().last_reason.empty());
  }
  CHECK(a.peers().empty());
  check_alive(a);
}

TEST_CASE("tcp: a handshake that never ends is timed out", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpOptions impatient = options(1);
  impatient.handshake_timeout = std::chrono::milliseconds(150);
  TcpTransport a(impatient);
  raw::Socket mute = raw::Socket::connect(a.local_port());
  raw::Socket drip = raw::Socket::connect(a.local_port());
  raw::Socket half_way = raw::Socket::connect(a.local_port());
  REQUIRE(half_way.send(raw::hello({.peer = 3})));
  const raw::Bytes hello = raw::hello({.peer = 2});
  std::size_t at = 0;
  CHECK(eventually([&] {  // a byte now and then does not buy time
    if (at + 1 < hello.size()) drip.send({hello[at++]});
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return a.strangers().timed_out == 3;
  }));
  CHECK(mute.ends());
  CHECK(drip.ends());
  CHECK(half_way.ends());
  CHECK(a.strangers().last_reason == "handshake timed out");
}

TEST_CASE("tcp: silent strangers do not keep peers out", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  std::vector<raw::Socket> mute;
  for (int i = 0; i < 100; ++i) mute.push_back(raw::Socket::connect(a.local_port()));
  REQUIRE(eventually([&] { return a.strangers().accepted == 100; }));
  // A stranger is counted when accepted and again, a moment later, when refused.
  CHECK(eventually([&] { return a.strangers().refused == 100 - 32; }));
  check_alive(a);
}

TEST_CASE("tcp: a stranger with many idle connections pushes out its own", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  std::vector<raw::Socket> mute;
  const auto open = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) mute.push_back(raw::Socket::connect(a.local_port()));
  };
  open(16);
  raw::Socket away = raw::Socket::connect(a.local_port(), 0, INADDR_LOOPBACK + 0x100);
  REQUIRE(eventually([&] { return a.strangers().accepted == 17; }));
  open(100);
  REQUIRE(eventually([&] { return a.strangers().accepted == 117; }));
  // His first word comes late.
  raw::join(away, {.peer = 2});
  CHECK(eventually([&] { return connected(a, 2); }));
}

TEST_CASE("tcp: ids made up by strangers do not pile up", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpOptions small = options(1);
  small.max_peers = 2;
  TcpTransport a(small);
  for (PeerId id = 2; id < 60; ++id) {
    raw::Socket stranger = raw::Socket::connect(a.local_port());
    REQUIRE(stranger.send(raw::hello({.peer = id, .scene = 5})));
    REQUIRE(stranger.read(raw::kGoodbye));
  }
  CHECK(a.peers().size() <= 4 * small.max_peers);
  check_alive(a);
}

TEST_CASE("tcp: a process that lives for long meets any number of peers", "[net][socket]") {
  const raw::LeakCheck leaks;
  auto few = options(1);
  few.max_peers = 2;
  TcpTransport a(few);
  for (std::uint64_t id = 2; id < 20; ++id) {
    TcpTransport b(options(id, {a.local_port()}));
    REQUIRE(eventually([&] { return linked(a, b); }));
  }
  CHECK(a.peers().size() <= 8);  // four times as many ids as peers are remembered
}

TEST_CASE("tcp: a full session refuses one more with the reason", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpOptions small = options(1);
  small.max_peers = 1;
  TcpTransport a(small);
  raw::Socket first = raw::Socket::connect(a.local_port());
  raw::join(first, {.peer = 2});
  REQUIRE(eventually([&] { return connected(a, 2); }));
  raw::Socket second = raw::Socket::connect(a.local_port());
  REQUIRE(second.send(raw::hello({.peer = 3})));
  const auto goodbye = second.read(raw::kGoodbye);
  REQUIRE(goodbye);
  CHECK(raw::as_text(goodbye->payload) == "session full: 1 peers");
  CHECK(connected(a, 2));
}

TEST_CASE("tcp: a peer gone bad is dropped with a reason", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  const raw::Bytes one = raw::le(1, 8);
  const std::vector<std::pair<raw::Bytes, std::string>> streams = {
      {raw::le(0, 4), "frame of length 0"},
      {raw::le(0xfffffff0, 4), "frame of length 4294967280"},
      {raw::le(65546, 4), "frame of length 65546"},
      {raw::frame(raw::kNewest, raw::Bytes(65537)), "payload of 65537 bytes"},
      {raw::frame(200, {}), "unknown frame type 200"},
      {raw::frame(0, {}), "unknown frame type 0"},
      {raw::hello({.peer = 2}), "unknown frame type 1"},
      {raw::frame(raw::kReliable, raw::le(1, 7)), "frame without its number"},
      {raw::frame(raw::kReliable, raw::le(0, 8)), "frame without its number"},
      {raw::frame(raw::kReliable, raw::le(2, 8)), "reliable frame out of order"},
      {raw::frame(raw::kReliable, raw::le(~0ull, 8)), "reliable frame out of order"},
      {raw::frame(raw::kAck, raw::le(1, 8)), "acknowledgement of what was never sent"},
      {raw::frame(raw::kAck, raw::le(0, 7)), "acknowledgement of what was never sent"},
      {raw::frame(raw::kAddresses, raw::Bytes(25)), "addresses cannot be decoded"},
  };
  for (std::size_t i = 0; i < streams.size(); ++i) {
    CAPTURE(i);
    raw::Socket peer = raw::Socket::connect(a.local_port());
    raw::join(peer, {.peer = 2, .incarnation = i + 1});
    REQUIRE(eventually([&] { return connected(a, 2); }));
    REQUIRE(peer.send(streams[i].first));
    const auto goodbye = peer.read(raw::kGoodbye);
    REQUIRE(goodbye);
    CHECK(raw::as_text(goodbye->payload).find("dropped: " + streams[i].second) == 0);
    CHECK_FALSE(connected(a, 2));
    CHECK(status(a, 2).reason.find("dropped: " + streams[i].second) == 0);
    CHECK(status(a, 2).rejected == i + 1);
  }
  std::vector<Packet> got;
  a.drain(got);
  CHECK(got.empty());
  check_alive(a);
}

TEST_CASE("tcp: a peer that acknowledges unsent messages is refused", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  for (const std::uint64_t received : {0ull, 5ull}) {  // known from the second time on
    raw::Socket peer = raw::Socket::connect(a.local_port());
    raw::join(peer, {.peer = 2}, received);
    if (received == 0) {
      REQUIRE(eventually([&] { return connected(a, 2); }));
    } else {
      const auto goodbye = peer.read(raw::kGoodbye);
      REQUIRE(goodbye);
      CHECK(raw::as_text(goodbye->payload) == "acknowledges frames that were never sent");
    }
  }
}

TEST_CASE("tcp: random bytes after a good handshake do no harm", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  std::mt19937_64 random(20261);
  for (std::uint64_t round = 1; round <= 150; ++round) {
    raw::Socket peer = raw::Socket::connect(a.local_port());
    raw::join(peer, {.peer = 2, .incarnation = round});
    for (int frames = 0; frames < 20; ++frames) {
      raw::Bytes payload(random() % 64);
      for (std::byte& b : payload) b = static_cast<std::byte>(random());
      // Mostly framed well, so that the payload is looked at as well as the frame.
      const bool framed = random() % 20 != 0;
      const auto type = static_cast<std::uint8_t>(random() % 10);
      if (!peer.send(framed ? raw::frame(type, payload) : payload)) break;
    }
    if (round % 2 == 0) peer.reset();  // within a frame, as often as not
  }
  std::vector<Packet> got;
  a.drain(got);
  CHECK(eventually([&] { return !connected(a, 2); }));
  CHECK(status(a, 2).rejected > 0);
  got.clear();
  a.drain(got);
  check_alive(a);
}

TEST_CASE("tcp: addresses told by a peer are tried, and forgotten if they are none",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  raw::Socket peer = raw::Socket::connect(a.local_port());
  raw::join(peer, {.peer = 2});
  const std::uint16_t closed_port = TcpTransport(options(5)).local_port();
  const raw::Bytes v4_loopback =
      raw::le(0, 8) + raw::le(0, 2) + raw::le(0xffff, 2) + raw::le(0x0100007f, 4);
  // In the clear only this machine is dialled, whatever a peer says.
  const raw::Bytes elsewhere =
      raw::le(0, 8) + raw::le(0, 2) + raw::le(0xffff, 2) + raw::le(0x010200c0, 4);
  const auto entry = [&](PeerId id, const raw::Bytes& ip, std::uint16_t port) {
    return raw::le(id, 8) + ip + raw::le(port, 2);
  };
  raw::Bytes list = entry(7, v4_loopback, closed_port) + entry(1, v4_loopback, closed_port) +
                    entry(0, v4_loopback, closed_port) + entry(8, v4_loopback, 0) +
                    entry(8, raw::Bytes(16), closed_port) + entry(9, elsewhere, closed_port);
  REQUIRE(peer.send(raw::frame(raw::kAddresses, list)));
  REQUIRE(eventually([&] { return !a.dials().empty(); }));
  REQUIRE(a.dials().size() == 1);  // of the six only the first is an address of another peer here
  CHECK(a.dials()[0].address == HostPort{"127.0.0.1", closed_port});
  CHECK(eventually([&] { return a.dials().empty(); }));

  // A flood of them stays bounded.
  std::mt19937_64 random(3);
  for (int frames = 0; frames < 20; ++frames) {
    raw::Bytes many;
    for (int i = 0; i < 128; ++i) {
      many = many + entry(random() | 16, v4_loopback, closed_port);
    }
    REQUIRE(peer.send(raw::frame(raw::kAddresses, many)));
  }
  REQUIRE(peer.send(raw::frame(raw::kNewest, raw::text("done"))));
  CHECK(raw::receive(a, 1).size() == 1);
  CHECK(a.dials().size() <= 2 * TcpOptions{}.max_peers);
}

TEST_CASE("tcp: a member that sends ten million tiny frames is slowed, then dropped and told why",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(options(1));
  TcpTransport honest(options(3, {a.local_port()}));
  raw::Socket flood = raw::Socket::connect(a.local_port());
  raw::join(flood, {.peer = 2});
  REQUIRE(eventually([&] { return linked(a, honest); }));
  raw::Bytes many;
  const raw::Bytes tiny = raw::frame(raw::kNewest, {});
  for (int i = 0; i < 10'000; ++i) many.insert(many.end(), tiny.begin(), tiny.end());
  const auto began = std::chrono::steady_clock::now();
  std::thread sender([&] {
    for (int i = 0; i < 1000 && flood.send(many); ++i) continue;
  });
  std::vector<Packet> got;
  std::uint64_t posted = 0;
  std::uint64_t heard = 0;
  std::uint64_t flooded = 0;
  const bool dropped = eventually([&] {
    if (honest.post(1, raw::text("state"), Delivery::Newest)) ++posted;
    got.clear();
    a.drain(got);
    for (const Packet& packet : got) ++(packet.from == 3 ? heard : flooded);
    return !status(a, 2).connected;
  });
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  sender.join();
  CHECK(dropped);
  CHECK(status(a, 2).reason.find("dropped: sends more than a member may") == 0);
  const auto goodbye = flood.read(raw::kGoodbye);
  if (goodbye) CHECK(raw::as_text(goodbye->payload) == status(a, 2).reason);
  CHECK(status(a, 2).over_budget > 0);
  // 4096 at once and 16384 a second, of which no clock has to be fast.
  CHECK(static_cast<double>(flooded) <= 4096.0 + 16384.0 * seconds + 100.0);
  CHECK(linked(a, honest));
  CHECK(eventually([&] {
    got.clear();
    a.drain(got);
    heard += got.size();
    return heard == posted;
  }));
  CHECK(status(a, 3).over_budget == 0);
}

}  // namespace tcp_fault_test
