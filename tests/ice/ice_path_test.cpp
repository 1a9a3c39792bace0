// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Two peers on this host. NATs, STUN and TURN: tests/net/ice.sh.
#include "tandem/ice/ice_path.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <thread>

#include "support/catch.h"
#include "support/eventually.h"
#include "tandem/net/udp.h"

namespace ice_path_test {

using namespace tandem;
using ice::IceOptions;
using ice::IcePath;

using tandem::testing::eventually;

namespace {

net::UdpOptions options(consensus::PeerId self) {
  net::UdpOptions out;
  out.self = self;
  out.listen_address = "127.0.0.1";
  out.session_key.fill(7);
  return out;
}

std::shared_ptr<IcePath> path() {
  IceOptions options;
  options.address = "127.0.0.1";
  return std::make_shared<IcePath>(options);
}

bool connected(const net::UdpTransport& transport, consensus::PeerId peer) {
  for (const consensus::PeerStatus& each : transport.peers()) {
    if (each.id == peer) return each.connected;
  }
  return false;
}

}  // namespace

TEST_CASE("ice: two peers that know each other's description have a session", "[ice][socket]") {
  net::UdpTransport a(options(1));
  net::UdpTransport b(options(2));
  const auto here = path();
  const auto there = path();
  a.connect(here);  // before there is a way
  REQUIRE(eventually([&] {
    return here->state() == IcePath::State::Ready && there->state() == IcePath::State::Ready;
  }));
  CHECK(here->description().starts_with("tandem-ice 1\n"));
  here->connect(there->description());
  there->connect(here->description());
  CHECK_THROWS_AS(here->connect(there->description()), std::invalid_argument);
  b.connect(there);
  REQUIRE(eventually([&] { return connected(a, 2) && connected(b, 1); }));
  CHECK(here->state() == IcePath::State::Connected);
  CHECK(here->route() == "host to host");
  const std::vector<std::byte> message(30'000, std::byte{4});
  REQUIRE(a.post(2, message, consensus::Delivery::Reliable));
  std::vector<consensus::Packet> got;
  REQUIRE(eventually([&] {
    b.drain(got);
    return !got.empty();
  }));
  CHECK(got.front().bytes == message);
  // Straight, so that what the way carries is found out as over a socket.
  CHECK(here->max_datagram() == 1472);
  CHECK(eventually([&] {
    (void)a.post(2, std::vector<std::byte>(100), consensus::Delivery::Newest);
    (void)b.post(1, std::vector<std::byte>(100), consensus::Delivery::Newest);
    return a.max_packet_bytes(consensus::Delivery::Newest) == 1426 &&
           b.max_packet_bytes(consensus::Delivery::Newest) == 1426;
  }));
  const std::vector<std::byte> state(1426, std::byte{5});
  CHECK(eventually([&] {
    (void)a.post(2, state, consensus::Delivery::Newest);
    got.clear();
    b.drain(got);
    return std::ranges::any_of(got, [&](const auto& each) { return each.bytes == state; });
  }));
}

TEST_CASE("ice: options that are not valid are named", "[ice][fault]") {
  IceOptions two;
  two.stun = {{"127.0.0.1", 1}, {"127.0.0.1", 2}};
  CHECK_THROWS_WITH(IcePath(two), "IceOptions: stun must be at most one server, is 2 servers");
  IceOptions relay;
  relay.relay_only = true;
  CHECK_THROWS_WITH(IcePath(relay), "IceOptions: relay_only must be false without turn, is true");
  IceOptions name;
  name.address = "localhost";
  CHECK_THROWS_AS(IcePath(name), std::invalid_argument);
  IceOptions nobody;
  nobody.turn = {{{"127.0.0.1", 9}, "", ""}};
  CHECK_THROWS_AS(IcePath(nobody), std::invalid_argument);
}

}  // namespace ice_path_test
