// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Whose a body of the square is, where its keeper and those who meet it do not hear each other.
#include "plaza/custody.h"

#include <chrono>
#include <thread>
#include <vector>

#include "consensus/stub_transport.h"
#include "nats/peers.h"
#include "plaza/visitor.h"

namespace tandem::demos {
namespace {

using namespace tandem::nats::testing;
using consensus::SessionTime;

constexpr SessionTime kStep = 1'000'000'000 / 60;  // ns
constexpr std::size_t kBall = 2;                   // the first body that is a ball
const consensus::SharedId kId = PlazaBody::id(kBall);

/// A person who stands still and hears what the test tells.
struct Person {
  Person(const PlazaOptions& options, std::uint16_t port, PeerId self, const Vec3& at)
      : wire(self),
        peer(scene.world(), wire, options.peer()),
        ledger({.hub = std::make_shared<nats::NatsHub>(
                    nats::HubOptions{.servers = {{"127.0.0.1", port}}}),
                .scene_hash = options.scene_hash(),
                .session_key = plaza_key(),
                .cells = options.cells()}),
        custody(options, self, scene, peer, ledger),
        feet(at) {
    scene.add(HalfSpace{}, {.type = BodyType::Static});
  }

  void step(SessionTime now) {
    custody.begin(feet, near, true, now);
    peer.before_step(now);
    scene.step(1.0 / 60.0);
    peer.after_step(now + kStep);
    custody.finish(feet, holds ? &kId : nullptr, now + kStep);
    // Time stands still until the server has answered, and told the others.
    REQUIRE(eventually([this] { return ledger.waiting() == 0; }));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  bool has_it() const { return custody.local().contains(kId); }
  Vec3 ball() const { return scene.world().pose(custody.local().at(kId).body).position; }
  void hear(PeerId from, const Vec3& position, SessionTime now) {
    wire.deliver(from,
                 consensus::StateUpdate{
                     .id = kId, .pose = {.position = position}, .influence = 1e-3F, .stamp = now});
  }
  void meet(PeerId other) {
    wire.known.push_back({.id = other, .connected = true});
    near.push_back(other);
  }

  Scene scene;
  consensus::testing::StubTransport wire;
  consensus::Peer peer;
  nats::BodyLedger ledger;
  Custody custody;
  Vec3 feet;
  std::vector<PeerId> near;
  bool holds = false;
};

/// Puts the ball there before anybody comes.
void lay(const PlazaOptions& options, std::uint16_t port, const Vec3& ball) {
  nats::BodyLedger ledger(
      {.hub = std::make_shared<nats::NatsHub>(nats::HubOptions{.servers = {{"127.0.0.1", port}}}),
       .scene_hash = options.scene_hash(),
       .session_key = plaza_key(),
       .cells = options.cells()});
  REQUIRE(ledger.write(kId, 0, {.position = ball}, {}));
  REQUIRE(eventually([&] { return ledger.waiting() == 0; }));
}

const PlazaOptions kOptions{.people = 3, .bodies = kBall + 1};
const Vec3 kAt(6.0, 6.0, PlazaBody::kHalf);  ///< the ball, in the middle of a cell

TEST_CASE("A body carried for long stays its keeper's, even where the keeper is not heard",
          "[nats]") {
  if (!has_server()) return;
  Server server;
  lay(kOptions, server.port(), kAt);
  // They are 8.5 m from each other, and connected up to 8.
  Person keeper(kOptions, server.port(), 1, kAt - Vec3(3.0, 0.0, 0.0));
  Person passer(kOptions, server.port(), 2, kAt + Vec3(5.5, 0.0, 0.0));
  SessionTime now = 1'000'000'000;
  const auto step = [&](double seconds, bool keeper_is_there) {
    for (const SessionTime end = now + static_cast<SessionTime>(1e9 * seconds); now < end;
         now += kStep) {
      if (keeper_is_there) keeper.step(now);
      passer.step(now);
    }
  };
  step(0.5, true);
  REQUIRE(keeper.has_it());
  keeper.holds = true;
  step(0.5, true);
  REQUIRE(passer.ledger.known(kId) != nullptr);
  REQUIRE(passer.ledger.known(kId)->keeper == 1);
  // Now the ball's place in the record is in reach.
  passer.feet = kAt + Vec3(3.5, 0.0, 0.0);
  step(8.0, true);
  CHECK(passer.ledger.known(kId)->keeper == 1);
  CHECK_FALSE(passer.has_it());
  CHECK(keeper.has_it());
  // A keeper that vanishes keeps it for 3 s and no longer.
  step(1.5, false);
  CHECK_FALSE(passer.has_it());
  step(2.0, false);
  CHECK(passer.has_it());
  CHECK(passer.ledger.known(kId)->keeper == 0);
}

TEST_CASE("Where the keeper's record says otherwise a neighbour's old copy is not taken up",
          "[nats]") {
  if (!has_server()) return;
  Server server;
  lay(kOptions, server.port(), kAt);
  Person keeper(kOptions, server.port(), 1, kAt - Vec3(3.0, 0.0, 0.0));
  Person other(kOptions, server.port(), 2, kAt + Vec3(5.5, 0.0, 0.0));
  other.meet(3);
  SessionTime now = 1'000'000'000;
  std::uint64_t revision = 0;
  int told = 0;
  for (int step = 0; step < 300; ++step, now += kStep) {
    keeper.holds = step > 30;
    keeper.step(now);
    const nats::LedgerRecord* const record = other.ledger.known(kId);
    const bool is_new = record != nullptr && record->keeper == 1 && record->revision > revision;
    if (is_new) {
      revision = record->revision;
      // Within reach of who hears it, and 3 m from where the keeper has just said that it is.
      other.hear(3, kAt + Vec3(3.0, 0.0, 0.0), now);
      ++told;
    }
    other.step(now);
    CHECK_FALSE(other.has_it());
  }
  CHECK(told >= 3);
}

TEST_CASE("A body that leaves its keeper goes to a neighbour who has it", "[nats]") {
  if (!has_server()) return;
  Server server;
  lay(kOptions, server.port(), kAt);
  Person thrower(kOptions, server.port(), 1, kAt - Vec3(3.0, 0.0, 0.0));
  Person catcher(kOptions, server.port(), 2, kAt + Vec3(2.0, 0.0, 0.0));
  thrower.meet(2);
  catcher.meet(1);
  SessionTime now = 1'000'000'000;
  const auto step = [&](int steps) {
    for (int i = 0; i < steps; ++i, now += kStep) {
      if (catcher.has_it()) thrower.hear(2, catcher.ball(), now);
      if (thrower.has_it()) catcher.hear(1, thrower.ball(), now);
      thrower.step(now);
      catcher.step(now);
    }
  };
  step(30);
  thrower.holds = true;
  step(60);
  REQUIRE(catcher.ledger.known(kId)->keeper == 1);
  thrower.holds = false;
  thrower.feet -= Vec3(1.0, 0.0, 0.0);
  thrower.scene.world().set_twist(thrower.custody.local().at(kId).body,
                                  {.linear = Vec3(1.0, 0.0, 0.0)});
  catcher.scene.world().set_twist(catcher.custody.local().at(kId).body,
                                  {.linear = Vec3(1.0, 0.0, 0.0)});
  step(90);
  CHECK(catcher.ledger.known(kId)->keeper == 2);
}

}  // namespace
}  // namespace tandem::demos
