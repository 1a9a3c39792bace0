// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Real sockets on loopback.
#include "tandem/net/udp.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <stdexcept>
#include <thread>

#include "support/catch.h"
#include "support/eventually.h"
#include "support/sockets.h"

namespace udp_test {

using namespace tandem::net;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerId;
using tandem::consensus::PeerStatus;

using tandem::testing::eventually;

namespace {

Key key(std::uint8_t fill) {
  Key out;
  out.fill(fill);
  return out;
}

UdpOptions options(PeerId self, const std::vector<std::uint16_t>& dial = {}) {
  UdpOptions out;
  out.self = self;
  out.listen_address = "127.0.0.1";
  out.session_key = key(7);
  out.kbit_per_s = 20'000.0;
  for (const std::uint16_t port : dial) out.connect.push_back({"127.0.0.1", port});
  return out;
}

/// Peers whose keys all others know: nobody else can use packets that relays pass on between them.
UdpOptions listed(UdpOptions out) {
  out.identity = key(static_cast<std::uint8_t>(out.self));
  for (PeerId peer = 1; peer <= 3; ++peer) {
    if (peer == out.self) continue;
    out.trusted.push_back(
        {.peer = peer, .public_key = public_key(key(static_cast<std::uint8_t>(peer)))});
  }
  return out;
}

PeerStatus status(const UdpTransport& transport, PeerId peer) {
  for (const PeerStatus& each : transport.peers()) {
    if (each.id == peer) return each;
  }
  return {};
}

std::vector<std::byte> bytes(std::size_t size, std::uint8_t first) {
  std::vector<std::byte> out(size, std::byte{3});
  out[0] = std::byte{first};
  return out;
}

}  // namespace

TEST_CASE("udp: two peers on loopback exchange states and long messages, and part in order",
          "[net][socket]") {
  UdpTransport a(options(1));
  auto b = std::make_unique<UdpTransport>(options(2, {a.local_port()}));
  REQUIRE(eventually([&] { return status(a, 2).connected && status(*b, 1).connected; }));
  CHECK(b->max_packet_bytes(Delivery::Newest) >= 1154);
  for (std::uint8_t i = 0; i < 40; ++i) {
    REQUIRE(b->post(1, bytes(20'000, i), Delivery::Reliable));
    REQUIRE(b->post(1, bytes(1154, i), Delivery::Newest));
  }
  // Loopback carries all that a socket takes.
  CHECK(eventually([&] { return b->max_packet_bytes(Delivery::Newest) == 1472 - 46; }));
  CHECK_FALSE(b->post(1, bytes(1427, 0), Delivery::Newest));
  CHECK_FALSE(b->post(9, bytes(10, 0), Delivery::Newest));
  std::uint8_t next = 0;
  REQUIRE(eventually([&] {
    std::vector<Packet> got;
    a.drain(got);
    for (const Packet& packet : got) {
      if (packet.bytes.size() == 20'000) CHECK(packet.bytes == bytes(20'000, next++));
    }
    return next == 40;
  }));
  CHECK(status(a, 2).bytes_in > 800'000);
  b.reset();
  REQUIRE(eventually([&] { return !status(a, 2).connected; }));
  CHECK(status(a, 2).reason == "peer: has left");
}

TEST_CASE("udp: the last Reliable message arrives although the peer leaves at once",
          "[net][socket]") {
  UdpTransport a(options(1));
  {
    auto last = options(2, {a.local_port()});
    last.flush_timeout = std::chrono::seconds(10);
    UdpTransport b(last);
    REQUIRE(eventually([&] { return status(b, 1).connected; }));
    REQUIRE(b.post(1, bytes(30'000, 9), Delivery::Reliable));
  }
  std::vector<Packet> got;
  REQUIRE(eventually([&] {
    a.drain(got);
    return !got.empty();
  }));
  CHECK(got.front().bytes == bytes(30'000, 9));
}

TEST_CASE("udp: four peers with public keys make a full mesh, a fifth without a key stays out",
          "[net][socket]") {
  std::vector<std::unique_ptr<UdpTransport>> peers;
  std::vector<std::uint16_t> ports;
  for (PeerId self = 1; self <= 4; ++self) {
    auto own = options(self, ports);
    own.identity = key(static_cast<std::uint8_t>(self));
    for (PeerId other = 1; other <= 4; ++other) {
      if (other == self) continue;
      own.trusted.push_back(
          {.peer = other, .public_key = public_key(key(static_cast<std::uint8_t>(other)))});
    }
    peers.push_back(std::make_unique<UdpTransport>(own));
    ports.push_back(peers.back()->local_port());
  }
  UdpTransport stranger(options(5, ports));  // the session key is right, its own key is on no list
  auto outsider_options = options(6, ports);
  outsider_options.session_key = key(8);
  UdpTransport outsider(outsider_options);
  REQUIRE(eventually([&] {
    for (const auto& peer : peers) {
      std::size_t connected = 0;
      for (const PeerStatus& each : peer->peers()) connected += each.connected ? 1 : 0;
      if (connected != 3) return false;
    }
    return peers[0]->strangers().refused > 0 && peers[0]->strangers().bad_proof > 0;
  }));
  for (const auto& peer : peers) {
    CHECK_FALSE(status(*peer, 5).connected);
    CHECK_FALSE(status(*peer, 6).connected);
  }
  CHECK(outsider.peers().empty());

  for (const auto& from : peers) {
    for (PeerId to = 1; to <= 4; ++to) {
      if (to != from->self()) {
        REQUIRE(from->post(to, bytes(100, static_cast<std::uint8_t>(from->self())),
                           Delivery::Reliable));
      }
    }
  }
  for (const auto& to : peers) {
    std::vector<Packet> got;
    REQUIRE(eventually([&] {
      to->drain(got);
      return got.size() == 3;
    }));
    for (const Packet& packet : got) {
      CHECK(packet.bytes == bytes(100, static_cast<std::uint8_t>(packet.from)));
    }
  }
}

TEST_CASE("udp: a live session under junk, oversized datagrams, questions and recordings",
          "[net][socket][fault]") {
  const bool filtered = GENERATE(true, false);
  auto own = options(1);
  own.kernel_filter = filtered;
  UdpTransport a(own);
  auto other = options(2, {a.local_port()});
  other.kernel_filter = filtered;
  UdpTransport b(other);
  REQUIRE(eventually([&] { return status(a, 2).connected && status(b, 1).connected; }));

  const int attacker = ::socket(AF_INET, SOCK_DGRAM, 0);
  REQUIRE(attacker >= 0);
  sockaddr_in target{};
  target.sin_family = AF_INET;
  target.sin_port = htons(a.local_port());
  target.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::uint64_t state = 1;
  const auto random = [&state] {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint8_t>(state >> 56);
  };
  std::vector<std::uint8_t> junk(60'000);
  std::uint8_t posted = 0;
  std::uint8_t got = 0;
  REQUIRE(eventually([&] {
    for (int i = 0; i < 200; ++i) {
      const std::size_t size = i % 40 == 0 ? 60'000 : std::size_t{random()} * 6;
      for (std::size_t k = 0; k < std::min<std::size_t>(size, 64); ++k) junk[k] = random();
      if (i % 3 == 0) junk[0] = 0x40;
      if (i % 3 == 1) {  // a question, mostly of the wrong length
        const std::array<std::uint8_t, 7> hello{1, 'T', 'N', 'D', 'U', 1, 0};
        std::copy(hello.begin(), hello.end(), junk.begin());
      }
      (void)::sendto(attacker, junk.data(), i % 6 == 1 ? 64 : size, 0,
                     reinterpret_cast<const sockaddr*>(&target), sizeof target);
    }
    if (posted < 100) REQUIRE(b.post(1, bytes(500, posted++), Delivery::Reliable));
    std::vector<Packet> packets;
    a.drain(packets);
    for (const Packet& packet : packets) CHECK(packet.bytes == bytes(500, got++));
    return got == 100;
  }));
  tandem::testing::close_socket(attacker);
  CHECK(status(a, 2).connected);
  CHECK(status(a, 2).rejected == 0);
  CHECK(a.strangers().challenged + a.strangers().limited > 100);
  CHECK(a.strangers().bad_proof == 0);
  if (!filtered) CHECK(a.strangers().malformed > 1000);
#ifdef __linux__
  // A datagram passed as a packet only once in 65536 times so far.
  if (filtered) CHECK(a.strangers().unknown < 10);
#endif
}

TEST_CASE("udp: one address is enough to meet all, and all have one time", "[net][socket][clock]") {
  UdpTransport first(options(1));
  std::vector<std::unique_ptr<UdpTransport>> peers;
  std::uint16_t port = first.local_port();
  for (PeerId self = 2; self <= 5; ++self) {
    peers.push_back(std::make_unique<UdpTransport>(options(self, {port})));
    port = peers.back()->local_port();  // a chain
  }
  // A peer that met peer 4 first may follow its clock until peer 1's is known too.
  REQUIRE(eventually([&] {
    for (const auto& peer : peers) {
      std::size_t connected = 0;
      for (const PeerStatus& each : peer->peers()) connected += each.connected ? 1 : 0;
      const ClockStatus clock = peer->clock();
      if (connected != 4 || !clock.synchronised || clock.reference != 1) return false;
      if (peer->relay_of(1) != 0) return false;
    }
    return first.clock().synchronised;
  }));
  for (const auto& peer : peers) {
    // By the bound when the clock was read; between two readings this thread may sleep.
    const auto before = first.session_now();
    const auto mine = peer->clock();
    const auto after = first.session_now();
    CHECK(mine.now >= before - mine.error_bound);
    CHECK(mine.now <= after + mine.error_bound);
  }
}

TEST_CASE("udp: names are looked up until they are found, and none holds up the others",
          "[net][socket]") {
  UdpTransport a(options(1));
  auto own = options(2);
  own.backoff_max = std::chrono::milliseconds(100);
  // Longer than a name can be: no server of names is asked.
  own.connect = {{std::string(300, 'x'), 9}, {"localhost", a.local_port()}};
  const UdpTransport b(own);
  REQUIRE(eventually([&] { return status(b, 1).connected; }));
  REQUIRE(eventually([&] { return b.lookups()[0].attempts >= 3; }));
  const auto lookups = b.lookups();
  REQUIRE(lookups.size() == 2);
  CHECK(lookups[0].address.port == 9);
  CHECK_FALSE(lookups[0].found);
  CHECK(lookups[0].reason.starts_with("cannot look up the host: "));
  CHECK(lookups[1].found);
  CHECK(lookups[1].attempts == 1);
  CHECK(lookups[1].reason.empty());
}

TEST_CASE("udp: a peer with IPv4 alone and one with IPv6 alone meet through one that has both",
          "[net][socket]") {
  auto both = listed(options(2));
  both.listen_address = "::";
  std::unique_ptr<UdpTransport> relay;
  std::unique_ptr<UdpTransport> six;
  try {
    relay = std::make_unique<UdpTransport>(both);
    auto own = listed(options(3));
    own.listen_address = "::1";
    own.connect = {{"::1", relay->local_port()}};
    six = std::make_unique<UdpTransport>(own);
  } catch (const std::system_error&) {
    WARN("no IPv6 on this host: not tested");
    return;
  }
  UdpTransport four(listed(options(1, {relay->local_port()})));
  REQUIRE(eventually([&] { return status(four, 3).connected && status(*six, 1).connected; }));
  CHECK(four.relay_of(3) == 2);
  CHECK(six->relay_of(1) == 2);
  std::uint8_t next = 0;
  for (std::uint8_t i = 0; i < 20; ++i) {
    REQUIRE(four.post(3, bytes(3000, i), Delivery::Reliable));
  }
  REQUIRE(eventually([&] {
    std::vector<Packet> got;
    six->drain(got);
    for (const Packet& packet : got) {
      CHECK(packet.from == 1);
      CHECK(packet.bytes == bytes(3000, next++));
    }
    return next == 20;
  }));
  CHECK(relay->relayed().forwarded > 50);  // 60 kB in datagrams of at most 1200
}

TEST_CASE("udp: options that are not valid are named, a port in use is an error", "[net][fault]") {
  auto zero = options(1);
  zero.session_key = {};
  CHECK_THROWS_AS(UdpTransport(zero), std::invalid_argument);
  auto small = options(1);
  small.max_datagram = 500;
  CHECK_THROWS_WITH(UdpTransport(small), "UdpOptions: max_datagram must be in [548, 1472], is 500");
  UdpTransport a(options(1));
  auto taken = options(2);
  taken.listen_port = a.local_port();
  CHECK_THROWS_AS(UdpTransport(taken), std::system_error);
}

}  // namespace udp_test
