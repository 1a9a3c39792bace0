// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// UdpTransport over ways that are no socket of its own, and with real sockets that change.

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "support/catch.h"
#include "support/eventually.h"
#include "support/sockets.h"
#include "tandem/net/udp.h"

namespace udp_path_test {

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

UdpOptions options(PeerId self) {
  UdpOptions out;
  out.self = self;
  out.listen_address = "127.0.0.1";
  out.session_key = key(7);
  out.identity = key(static_cast<std::uint8_t>(self));
  for (PeerId peer = 1; peer <= 3; ++peer) {
    if (peer == self) continue;
    out.trusted.push_back(
        {.peer = peer, .public_key = public_key(key(static_cast<std::uint8_t>(peer)))});
  }
  return out;
}

bool connected(const UdpTransport& transport, PeerId peer) {
  for (const PeerStatus& each : transport.peers()) {
    if (each.id == peer) return each.connected;
  }
  return false;
}

/// One end of a pipe in memory; what one sends the other has received when send() returns.
class Pipe final : public DatagramPath {
 public:
  /// @param said  max_datagram(); what is longer than `borne` is lost
  static std::pair<std::shared_ptr<Pipe>, std::shared_ptr<Pipe>> make(std::size_t said = 1200,
                                                                      std::size_t borne = 1300) {
    auto ends = std::pair(std::make_shared<Pipe>(), std::make_shared<Pipe>());
    for (Pipe* end : {ends.first.get(), ends.second.get()}) {
      end->said_ = said;
      end->borne_ = borne;
    }
    ends.first->other_ = ends.second;
    ends.second->other_ = ends.first;
    return ends;
  }
  void send(std::span<const std::byte> datagram) override {
    const auto other = other_.lock();
    if (other && datagram.size() <= borne_) other->deliver(datagram);
  }
  std::size_t max_datagram() const override { return said_; }
  void receive(Receive receive) override {
    const std::scoped_lock lock(mutex_);
    receive_ = std::move(receive);
  }

 private:
  void deliver(std::span<const std::byte> datagram) {
    const std::scoped_lock lock(mutex_);
    if (receive_) receive_(datagram);
  }
  std::size_t said_ = 0;
  std::size_t borne_ = 0;
  std::weak_ptr<Pipe> other_;
  std::mutex mutex_;
  Receive receive_;
};

/// A machine with one network, and then another one: a socket to a port of this host, from
/// 127.0.0.`host`.
class Roamer final : public DatagramPath {
 public:
  explicit Roamer(std::uint16_t port) : port_(port), socket_(open(2)), thread_([this] { run(); }) {}
  ~Roamer() override {
    ends_ = true;
    thread_.join();
    tandem::testing::close_socket(socket_);
  }
  Roamer(const Roamer&) = delete;
  Roamer& operator=(const Roamer&) = delete;

  void move(std::uint8_t host) {
    const std::scoped_lock lock(mutex_);
    tandem::testing::close_socket(socket_);
    socket_ = open(host);
  }
  void send(std::span<const std::byte> datagram) override {
    const std::scoped_lock lock(mutex_);
    (void)::send(socket_, datagram.data(), datagram.size(), 0);
  }
  void receive(Receive receive) override {
    const std::scoped_lock lock(receiving_);
    receive_ = std::move(receive);
  }

 private:
  static sockaddr_in address(std::uint8_t host, std::uint16_t port) {
    sockaddr_in out{};
    out.sin_family = AF_INET;
    out.sin_port = htons(port);
    out.sin_addr.s_addr = htonl(0x7f000000U | host);
    return out;
  }
  int open(std::uint8_t host) const {
    const int out = tandem::testing::nonblocking_socket(SOCK_DGRAM);
    const sockaddr_in own = address(host, 0);
    const sockaddr_in to = address(1, port_);
    if (::bind(out, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 ||
        ::connect(out, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      throw std::runtime_error("no socket on 127.0.0." + std::to_string(host));
    }
    return out;
  }
  void run() {
    std::array<std::byte, 2048> buffer{};
    while (!ends_) {
      ssize_t got = 0;
      {
        const std::scoped_lock lock(mutex_);
        got = ::recv(socket_, buffer.data(), buffer.size(), 0);
      }
      if (got <= 0) {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        continue;
      }
      const std::scoped_lock lock(receiving_);
      if (receive_) receive_(std::span(buffer).first(static_cast<std::size_t>(got)));
    }
  }

  std::uint16_t port_;
  std::mutex mutex_;
  int socket_;
  std::mutex receiving_;
  Receive receive_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace

TEST_CASE("udp path: peers meet over a way that is no address, and a third one through them",
          "[net][socket]") {
  auto [here, there] = Pipe::make();
  UdpTransport a(options(1));
  auto elsewhere = options(2);
  elsewhere.listen_address = "::1";  // its socket reaches nobody
  std::unique_ptr<UdpTransport> b;
  try {
    b = std::make_unique<UdpTransport>(elsewhere);
  } catch (const std::system_error&) {
    WARN("no IPv6 on this host: not tested");
    return;
  }
  a.connect(here);
  b->connect(there);
  REQUIRE(eventually([&] { return connected(a, 2) && connected(*b, 1); }));
  auto third = options(3);
  third.connect = {{"127.0.0.1", a.local_port()}};
  UdpTransport c(third);
  // 2 and 3 have no way to each other but through 1: the pipe is nobody else's.
  REQUIRE(eventually([&] { return connected(c, 2) && connected(*b, 3); }));
  CHECK(c.relay_of(2) == 1);
  const std::vector<std::byte> message(20'000, std::byte{5});
  REQUIRE(c.post(2, message, Delivery::Reliable));
  REQUIRE(a.post(2, message, Delivery::Reliable));
  std::size_t got = 0;
  CHECK(eventually([&] {
    std::vector<Packet> packets;
    b->drain(packets);
    for (const Packet& packet : packets) got += packet.bytes == message ? 1 : 0;
    return got == 2;
  }));
  // Nothing is known of this path except that it carries what every path does.
  CHECK(b->max_packet_bytes(Delivery::Newest) == 1154);
  b.reset();
  CHECK(eventually([&] { return !connected(a, 2); }));
  CHECK_THROWS_AS(a.connect(nullptr), std::invalid_argument);
}

TEST_CASE("udp path: a way that is taken away is kept by nobody, and another one does",
          "[net][socket]") {
  UdpTransport a(options(1));
  UdpTransport b(options(2));
  for (int meeting = 0; meeting < 20; ++meeting) {
    auto [here, there] = Pipe::make();
    a.connect(here);
    b.connect(there);
    REQUIRE(eventually([&] { return connected(a, 2) && connected(b, 1); }));
    a.disconnect(*here);
    CHECK_FALSE(connected(a, 2));
    // A datagram that the other end is sending holds it for a moment.
    CHECK(eventually([&way = here] { return way.use_count() == 1; }));
    // The other one has been told.
    REQUIRE(eventually([&] { return !connected(b, 1); }));
    b.disconnect(*there);
    b.disconnect(*there);
    CHECK(eventually([&way = there] { return way.use_count() == 1; }));
  }
}

TEST_CASE("udp path: how long datagrams may be is found out where a way says that it cuts none",
          "[net][socket]") {
  // One that bears 1400 bytes, whatever it says; another one says less than all ways bear.
  auto [here, there] = Pipe::make(1472, 1400);
  UdpTransport a(options(1));
  UdpTransport b(options(2));
  a.connect(here);
  b.connect(there);
  REQUIRE(eventually([&] { return connected(a, 2) && connected(b, 1); }));
  const auto longest = [](const UdpTransport& of) { return of.max_packet_bytes(Delivery::Newest); };
  // Found to 16 bytes; 46 of them are headers.
  CHECK(eventually([&] {
    (void)a.post(2, std::vector<std::byte>(100), Delivery::Newest);
    (void)b.post(1, std::vector<std::byte>(100), Delivery::Newest);
    return longest(a) > 1400 - 46 - 16 && longest(b) > 1400 - 46 - 16;
  }));
  CHECK(longest(a) <= 1400 - 46);
  CHECK(longest(b) <= 1400 - 46);
  auto [low, high] = Pipe::make(100, 1400);
  UdpTransport c(options(1));
  UdpTransport d(options(2));
  c.connect(low);
  d.connect(high);
  REQUIRE(eventually([&] { return connected(c, 2) && connected(d, 1); }));
  CHECK(longest(c) == 1154);
}

TEST_CASE("udp path: a host that changes its network goes on, with real sockets",
          "[net][socket][fault]") {
  UdpTransport a(options(1));
  UdpTransport b(options(2));
  const auto roamer = std::make_shared<Roamer>(a.local_port());
  b.connect(roamer);
  REQUIRE(eventually([&] { return connected(a, 2) && connected(b, 1); }));
  std::uint8_t next = 0;
  for (std::uint8_t host = 3; host < 6; ++host) {
    roamer->move(host);
    for (std::uint8_t i = 0; i < 20; ++i) {
      const std::vector<std::byte> message(3000, static_cast<std::byte>(20 * (host - 3) + i));
      REQUIRE(a.post(2, message, Delivery::Reliable));
      REQUIRE(b.post(1, message, Delivery::Reliable));
    }
    std::uint8_t at_a = next;
    std::uint8_t at_b = next;
    next = static_cast<std::uint8_t>(next + 20);
    CHECK(eventually([&] {
      for (auto [transport, count] : {std::pair(&a, &at_a), std::pair(&b, &at_b)}) {
        std::vector<Packet> packets;
        transport->drain(packets);
        for (const Packet& packet : packets) {
          CHECK(packet.bytes.at(0) == static_cast<std::byte>((*count)++));
        }
      }
      return at_a == next && at_b == next;
    }));
  }
  // In one connection: 1 has seen one handshake.
  CHECK(a.strangers().challenged == 1);
}

}  // namespace udp_path_test
