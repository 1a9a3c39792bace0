// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The transactional scheme: one owner at a time, by request and grant.
#include <array>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::ownership_test {
namespace {

using namespace testing;

constexpr double kFrame = 1.0 / 60.0;
constexpr double kLatency = 0.06;  // s

std::unique_ptr<Session> balls(int peers) {
  LinkOptions link;
  link.latency = kLatency;
  auto session = std::make_unique<Session>(link);
  const PeerOptions options{.predictor = PredictorKind::Euler, .coupling = Coupling::SingleOwner};
  for (int i = 0; i < peers; ++i) {
    session->add(static_cast<PeerId>(i + 1), 0.003 * i, options, kWeightless)
        .share(ball(Vec3::Zero()));
  }
  return session;
}

/// Holds the ball at `anchor` from `from` to `to`, s since the start of the session.
std::function<void(Site&, SessionTime)> hold(double from, double to, const Vec3& anchor) {
  return [=, grab = GrabId{}](Site& site, SessionTime now) mutable {
    const double t = 1e-9 * static_cast<double>(now - kStart);
    if (grab.spring == 0 && t >= from && t < to) {
      grab = site.peer->grab({.body = kBody, .anchor_w = anchor, .stiffness = 50.0});
    }
    if (grab.spring != 0 && t >= to) {
      site.peer->release(grab);
      grab = {};
    }
  };
}

PeerId owner_at(const Site& site) { return site.peer->owner(kBody).value_or(0); }

TEST_CASE("single owner: the lowest id owns unclaimed bodies, and other copies follow it",
          "[consensus]") {
  const auto session = balls(3);
  session->run(1.5);
  for (const auto& site : session->sites) CHECK(owner_at(*site) == 1);
  Site& a = (*session)[0];
  Site& c = (*session)[2];
  c.displace({0.4, 0.0, 0.0});
  c.world.set_twist(c.body, {Vec3(1.0, 0.0, 0.0), Vec3::Zero()});
  session->run(3.0 * kFrame);
  CHECK(c.x() == Vec3::Zero());
  CHECK(c.v() == Vec3::Zero());
  session->run(0.5);
  CHECK(a.x() == Vec3::Zero());
  CHECK(a.v() == Vec3::Zero());
}

TEST_CASE("single owner: a holder owns a round trip later, and never two at once", "[consensus]") {
  const auto session = balls(3);
  (*session)[1].user = hold(2.0, 4.0, Vec3(0.2, 0.0, 0.0));
  double granted = 0.0;
  session->after = [&](Site& site) {
    int owners = 0;
    for (const auto& other : session->sites) owners += owner_at(*other) == other->id ? 1 : 0;
    CHECK(owners <= 1);
    const double t = 1e-9 * static_cast<double>(site.world_time() - kStart);
    if (granted == 0.0 && site.id == 2 && owner_at(site) == 2) granted = t;
  };
  session->run(3.0);
  INFO("granted at " << granted);
  CHECK(granted > 2.0 + 2.0 * kLatency);
  CHECK(granted < 2.0 + 2.0 * kLatency + 5.0 * kFrame);
  for (const auto& site : session->sites) CHECK(owner_at(*site) == 2);
  // It stays with who had it last.
  session->run(2.0);
  for (const auto& site : session->sites) CHECK(owner_at(*site) == 2);
}

TEST_CASE("single owner: after the grant nothing that others do moves the owner's body",
          "[consensus]") {
  // The same session twice, but for what happens to the copies of those who follow.
  std::array<std::uint64_t, 2> hashes{};
  for (std::size_t run = 0; run < 2; ++run) {
    const auto session = balls(2);
    (*session)[1].user = hold(2.0, 3.0, Vec3(0.2, 0.1, 0.0));
    session->run(2.4);
    CHECK(owner_at((*session)[1]) == 2);
    if (run == 1) {
      session->after = [](Site& site) {
        if (site.id == 1) site.displace({0.01, 0.3, 0.0});
      };
    }
    session->run(2.0);
    hashes[run] = (*session)[1].world.hash();
    session->after = nullptr;
    session->run(5.0 * kFrame);
    // The follower is where the owner is, carried on over the delay.
    CHECK(gap_now((*session)[0], (*session)[1]) < 1e-3);
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("single owner: the latest holder has it, then any that still holds", "[consensus]") {
  const auto session = balls(3);
  (*session)[1].user = hold(2.0, 6.0, Vec3(0.2, 0.0, 0.0));
  (*session)[2].user = hold(3.0, 5.0, Vec3(-0.2, 0.0, 0.0));
  session->run(2.9);
  CHECK(owner_at((*session)[0]) == 2);
  session->run(1.0);
  CHECK(owner_at((*session)[0]) == 3);
  session->run(1.0);
  CHECK(owner_at((*session)[0]) == 3);
  session->run(1.0);
  CHECK(owner_at((*session)[0]) == 2);
}

TEST_CASE("single owner: the bodies of a peer that left go to the lowest id", "[consensus]") {
  const auto session = balls(3);
  (*session)[2].user = hold(1.5, 2.0, Vec3(0.2, 0.0, 0.0));
  session->run(2.5);
  REQUIRE(owner_at((*session)[0]) == 3);
  (*session)[2].peer->leave((*session)[2].world_time());
  session->sites.pop_back();
  session->run(2.0);
  CHECK(owner_at((*session)[0]) == 1);
  CHECK(owner_at((*session)[1]) == 1);
}

// The rules, message by message -------------------------------------------------------------------

/// Peer 5 with one ball; the test plays everybody else.
class Table {
 public:
  Table() { site_.share(ball(Vec3::Zero())); }

  PeerId owner() const { return owner_at(site_); }
  /// It claims what nobody else does.
  void settle() {
    run(70);
    REQUIRE(owner() == 5);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      site_.peer->before_step(now_);
      site_.solver.step(site_.world, kFrame);
      now_ += ns(kFrame);
      site_.peer->after_step(now_);
    }
  }
  void grab() { site_.peer->grab({.body = kBody}); }
  void hear_claim(PeerId from, SessionTime stamp) {
    transport_.deliver(from, StateUpdate{.id = kBody, .influence = 1.0F, .stamp = stamp});
  }
  void hear(PeerId from, PeerId to, OwnershipEvent event, SessionTime stamp) {
    transport_.deliver(from,
                       OwnershipUpdate{.body = kBody, .to = to, .event = event, .stamp = stamp});
  }
  SessionTime now() const { return now_; }

 private:
  StubTransport transport_{5};
  Site site_{transport_, {.coupling = Coupling::SingleOwner}, kWeightless};
  SessionTime now_ = kStart;
};

TEST_CASE("single owner: acts of the same moment are the lower id's", "[consensus][unit]") {
  for (const PeerId asks : {PeerId{1}, PeerId{9}}) {
    Table table;
    table.settle();
    table.grab();
    table.run(1);
    // The act is known from the next step on.
    const SessionTime began = table.now();
    table.run(2);
    table.hear(asks, 5, OwnershipEvent::Request, began);
    table.run(1);
    CHECK(table.owner() == (asks == 1 ? 1 : 5));
  }
}

TEST_CASE("single owner: an earlier act asks in vain, and a later one that is none yet",
          "[consensus][unit]") {
  for (const int later : {-1, 1, 1000}) {
    Table table;
    table.settle();
    table.run(10);
    table.grab();
    table.run(1);
    const SessionTime began = table.now();
    table.run(3);
    table.hear(9, 5, OwnershipEvent::Request, began + later * ns(kFrame));
    table.run(1);
    CHECK(table.owner() == (later < 0 ? 5 : 9));
  }
}

TEST_CASE("single owner: a grant counts from the owner only, and old claims no more",
          "[consensus][unit]") {
  Table table;
  table.run(1);
  const SessionTime start = table.now();
  table.hear_claim(2, start);
  table.run(1);
  CHECK(table.owner() == 2);
  table.hear(3, 7, OwnershipEvent::Grant, start + 20'000'000);
  table.run(1);
  CHECK(table.owner() == 2);
  table.hear(2, 7, OwnershipEvent::Grant, start + 20'000'000);
  table.run(1);
  CHECK(table.owner() == 7);
  // States that the old owner sent before it gave the body away arrive late.
  table.hear_claim(2, start + 15'000'000);
  table.run(1);
  CHECK(table.owner() == 7);
}

TEST_CASE("single owner: of two owners the higher id gives way", "[consensus][unit]") {
  for (const PeerId other : {PeerId{1}, PeerId{9}}) {
    Table table;
    table.settle();
    table.hear_claim(other, table.now());
    table.run(1);
    CHECK(table.owner() == (other == 1 ? 1 : 5));
  }
}

TEST_CASE("codec: ownership survives the round trip, and faults are refused", "[consensus][unit]") {
  const std::array sent{
      OwnershipUpdate{.body = {1, 2}, .to = 3, .event = OwnershipEvent::Request, .stamp = -4},
      OwnershipUpdate{
          .body = {5, 6}, .to = ~PeerId{0}, .event = OwnershipEvent::Grant, .stamp = kStart}};
  std::vector<std::byte> bytes;
  REQUIRE(encode(std::span<const OwnershipUpdate>(sent), bytes) == 2);
  CHECK(bytes.size() == kHeaderBytes + 2 * kOwnershipBytes);
  DecodedPacket packet;
  REQUIRE(decode(bytes, packet).ok());
  REQUIRE(packet.ownership.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(packet.ownership[i].body == sent[i].body);
    CHECK(packet.ownership[i].to == sent[i].to);
    CHECK(packet.ownership[i].event == sent[i].event);
    CHECK(packet.ownership[i].stamp == sent[i].stamp);
  }
  bytes[kHeaderBytes + 24] = std::byte{7};  // event
  CHECK(decode(bytes, packet).fault == PacketFault::BadCode);
  CHECK(packet.ownership.empty());
  OwnershipUpdate bad = sent[0];
  bad.to = 0;
  CHECK(check(bad).fault == PacketFault::BadId);
  bad = sent[0];
  bad.body = {};
  CHECK(check(bad).fault == PacketFault::BadId);
  bad = sent[0];
  bad.stamp = kMaxStamp + 1;
  CHECK(check(bad).fault == PacketFault::OutOfRange);
}

}  // namespace
}  // namespace tandem::consensus::ownership_test
