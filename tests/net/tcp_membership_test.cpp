// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Who may be whom over real sockets, UDP and TCP alike.
#include <chrono>
#include <memory>

#include "raw_peer.h"
#include "support/catch.h"
#include "tandem/net/membership.h"
#include "tandem/net/udp.h"

namespace tcp_membership_test {

using namespace tandem::net;
using raw::eventually;
using tandem::consensus::Delivery;
using tandem::consensus::Packet;
using tandem::consensus::PeerStatus;
using tandem::consensus::Transport;

namespace {

Key key(std::uint8_t fill) {
  Key out{};
  out.fill(fill);
  return out;
}

const Key kOrganiser = key(99);

std::int64_t in_an_hour() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
             .count() +
         3600;
}

std::vector<std::byte> certificate(PeerId peer, const Key& identity, Role role = Role::Share) {
  return sign({.member = public_key(identity), .peer = peer, .role = role, .expires = in_an_hour()},
              kOrganiser);
}

TcpOptions tcp(PeerId self, const Key& identity, std::vector<std::uint16_t> connect = {}) {
  TcpOptions out = raw::options(self, std::move(connect));
  out.session_key = key(7);
  out.identity = identity;
  return out;
}

void certify(TcpOptions& options, Role role = Role::Share) {
  options.organiser = organiser_public_key(kOrganiser);
  options.certificate = certificate(options.self, *options.identity, role);
}

PeerStatus status(const Transport& at, PeerId of) {
  for (const PeerStatus& each : at.peers()) {
    if (each.id == of) return each;
  }
  return {};
}

bool linked(const Transport& a, const Transport& b) {
  return status(a, b.self()).connected && status(b, a.self()).connected;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string reason_of_dial(const TcpTransport& at) { return at.dials().front().reason; }

}  // namespace

TEST_CASE("tcp membership: a present member's id and derived ids cannot be taken",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpTransport a(tcp(1, key(1)));
  TcpTransport b(tcp(2, key(2), {a.local_port()}));
  REQUIRE(eventually([&] { return linked(a, b); }));
  TcpOptions liar = tcp(2, key(3), {a.local_port()});
  liar.incarnation = ~std::uint64_t{0};
  {
    TcpTransport mallory(liar);
    CHECK(
        eventually([&] { return has(reason_of_dial(mallory), "another key goes by peer id 2"); }));
    CHECK(linked(a, b));
  }
  liar.self = derived_id(public_key(key(2)));
  CHECK_THROWS_AS(TcpTransport(liar), std::invalid_argument);
  liar.self = derived_id(public_key(key(3)));
  TcpTransport honest(liar);
  CHECK(eventually([&] { return linked(a, honest); }));
}

TEST_CASE("tcp membership: certificates let in with their role, and a revoked member reads nothing",
          "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  TcpOptions one = tcp(1, key(1));
  certify(one);
  TcpTransport a(one);
  std::vector<std::unique_ptr<TcpTransport>> others;
  for (const PeerId peer : {2, 3, 4}) {
    TcpOptions own = tcp(peer, key(static_cast<std::uint8_t>(peer)), {a.local_port()});
    certify(own, peer == 3 ? Role::Watch : Role::Share);
    if (peer == 4) own.certificate = certificate(4, key(44));  // another key's
    others.push_back(std::make_unique<TcpTransport>(own));
  }
  const TcpTransport& b = *others[0];
  TcpTransport& c = *others[1];
  REQUIRE(eventually([&] { return linked(a, b) && linked(a, c) && linked(b, c); }));
  CHECK(eventually([&] { return has(reason_of_dial(*others[2]), "no certificate"); }));
  REQUIRE(c.post(1, raw::text("hm"), Delivery::Reliable));
  const auto got = raw::receive(a, 1);
  CHECK(got.front().role == Role::Watch);
  CHECK(status(a, 2).role == Role::Share);

  a.change_group(
      sign({.number = 1, .session_key = key(8), .revoked = {public_key(key(3))}}, kOrganiser));
  CHECK(eventually([&] { return a.group() == 1 && b.group() == 1; }));
  CHECK(eventually([&] { return !status(a, 3).connected && !status(b, 3).connected; }));
  CHECK_FALSE(a.post(3, raw::text("secret"), Delivery::Newest));
  CHECK(eventually([&] { return has(reason_of_dial(c), "revoked by the organiser"); }));
  CHECK(linked(a, b));
  // A member that has only the key of before comes in and hears of it.
  TcpOptions late = tcp(5, key(5), {a.local_port()});
  certify(late);
  TcpTransport e(late);
  CHECK(eventually([&] { return linked(a, e) && linked(b, e) && e.group() == 1; }));
}

TEST_CASE("tcp membership: of a stranger to the organiser nothing is taken", "[net][fault]") {
  const auto error = [](const TcpOptions& options) {
    try {
      options.validate();
    } catch (const std::invalid_argument& thrown) {
      return std::string(thrown.what());
    }
    return std::string();
  };
  TcpOptions options = tcp(1, key(1));
  certify(options);
  CHECK(error(options).empty());
  options.certificate.pop_back();
  CHECK(error(options) == "TcpOptions: certificate must be 121 bytes long, is 120");
  certify(options);
  options.organiser.reset();
  CHECK(error(options) == "TcpOptions: certificate must be none without an organiser, is given");
  certify(options);
  options.identity.reset();
  CHECK(error(options) == "TcpOptions: organiser must be none without an identity, is given");
  options.session_key.reset();
  options.certificate.clear();
  CHECK(error(options) == "TcpOptions: organiser must be none without a session_key, is given");
}

TEST_CASE("udp membership: the same over UDP", "[net][socket][fault]") {
  const raw::LeakCheck leaks;
  const auto member = [](PeerId self, std::vector<std::uint16_t> connect, Role role) {
    UdpOptions out;
    out.self = self;
    out.scene_hash = 5;
    out.listen_address = "127.0.0.1";
    for (const std::uint16_t port : connect) out.connect.push_back({"127.0.0.1", port});
    out.session_key = key(7);
    out.identity = key(static_cast<std::uint8_t>(self));
    out.organiser = organiser_public_key(kOrganiser);
    out.certificate = certificate(self, *out.identity, role);
    return out;
  };
  UdpTransport a(member(1, {}, Role::Share));
  UdpTransport b(member(2, {a.local_port()}, Role::Share));
  UdpTransport c(member(3, {a.local_port()}, Role::Act));
  REQUIRE(eventually([&] { return linked(a, b) && linked(a, c) && linked(b, c); }));
  CHECK(status(a, 3).role == Role::Act);
  REQUIRE(b.change_group(
      sign({.number = 1, .session_key = key(8), .revoked = {public_key(key(3))}}, kOrganiser)));
  CHECK_FALSE(b.change_group(sign({.number = 2, .session_key = key(8)}, key(98))));
  CHECK(eventually([&] { return a.group() == 1 && !status(a, 3).connected; }));
  CHECK_FALSE(status(b, 3).connected);
  CHECK(linked(a, b));
}

}  // namespace tcp_membership_test
