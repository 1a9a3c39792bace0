// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Same inputs, same bits: a session run again, and one peer run again on what it once heard.
#include <cstdint>

#include "consensus/peer_fixture.h"
#include "consensus/random.h"
#include "consensus/stub_transport.h"
#include "support/catch.h"

namespace tandem::consensus::peer_replay_test {
namespace {

using namespace testing;

constexpr double kSeconds = 3.0;

using Hashes = std::vector<std::uint64_t>;

LinkOptions rough_link() {
  LinkOptions link = network_profile(4);
  link.loss = 0.05;
  link.duplicate = 0.05;
  link.reorder = 0.1;
  return link;
}

/// A cube on a plane, displaced and moving a little differently at each peer.
void furnish(Site& site) {
  Dice dice(40 + site.id);
  site.share(cube(Vec3(0.0, 0.0, kHalf.z() + 0.02) + dice.vec3(0.01), dice.rotation(0.1)));
  site.world.set_twist(site.body, {dice.vec3(0.3), dice.vec3(0.5)});
  put_on_plane(site);
}

/// The user of the second peer takes the cube and lifts it.
std::function<void(Site&, SessionTime)> lifting_user() {
  return [grab = GrabId{}, done = false](Site& site, SessionTime now) mutable {
    if (done) return;
    const double t = 1e-9 * static_cast<double>(now - kStart);
    if (grab.spring == 0 && t > 1.0) grab = site.peer->grab({.body = kBody, .anchor_w = site.x()});
    if (grab.spring != 0 && t < 2.0) {
      site.peer->move(grab, Vec3(0.1 * (t - 1.0), 0.0, 0.1 + 0.2 * (t - 1.0)), now);
    }
    if (grab.spring != 0 && t >= 2.0) {
      site.peer->release(grab);
      done = true;
    }
  };
}

std::unique_ptr<Session> session_of(std::uint64_t seed) {
  auto session = std::make_unique<Session>(rough_link(), kStart, seed);
  for (int i = 0; i < 2; ++i) {
    furnish(session->add(static_cast<PeerId>(i + 1), 0.007 * i, {}, {}, i == 0 ? 60.0 : 72.0));
  }
  (*session)[1].user = lifting_user();
  return session;
}

/// The hash of each peer's world after each of its steps.
Hashes hashes_of(Session& session) {
  Hashes hashes;
  session.after = [&](Site& site) { hashes.push_back(site.world.hash()); };
  session.run(kSeconds);
  return hashes;
}

TEST_CASE("peer: a session run again gives the same bits, another link others", "[consensus]") {
  const Hashes once = hashes_of(*session_of(1));
  const Hashes again = hashes_of(*session_of(1));
  const Hashes other = hashes_of(*session_of(2));
  CHECK(once.size() == 395);  // 60 and 72 steps a second for 3 s, less the last of the second
  CHECK(once == again);
  CHECK(once != other);
}

TEST_CASE("peer: a recorded inbox played back gives the same bits", "[consensus]") {
  // The first peer of the session, through a transport that keeps what it drains.
  VirtualNetwork network(rough_link(), 1, kStart);
  network.transport(1);
  Site speaker(network.transport(2), {}, {});
  RecordingTransport recorder(network.transport(1));
  Site listener(recorder, {}, {});
  furnish(listener);
  furnish(speaker);
  speaker.user = lifting_user();

  const auto time_of = [](int step) {
    return kStart + std::llround(static_cast<double>(step) * 1e9 / 60.0);
  };
  const auto step = [&](Site& site, int k) {
    if (site.user) site.user(site, time_of(k));
    site.peer->before_step(time_of(k));
    site.solver.step(site.world, 1e-9 * static_cast<double>(time_of(k + 1) - time_of(k)));
  };
  constexpr int kSteps = 180;
  Hashes lived;
  for (int k = 0; k < kSteps; ++k) {
    network.advance_to(time_of(k));
    step(listener, k);
    step(speaker, k);
    network.advance_to(time_of(k + 1));
    listener.peer->after_step(time_of(k + 1));
    speaker.peer->after_step(time_of(k + 1));
    lived.push_back(listener.world.hash());
  }
  REQUIRE(recorder.recording.size() == kSteps);

  const auto replay = [&](bool with_spring) {
    StubTransport stub(1);
    Site site(stub, {}, {});
    furnish(site);
    Hashes hashes;
    for (int k = 0; k < kSteps; ++k) {
      for (const Packet& packet : recorder.recording[static_cast<std::size_t>(k)]) {
        const bool spring = packet.bytes.size() == kHeaderBytes + kSpringBytes;
        if (with_spring || !spring) stub.inbox.push_back(packet);
      }
      step(site, k);
      site.peer->after_step(time_of(k + 1));
      hashes.push_back(site.world.hash());
    }
    return hashes;
  };
  CHECK(replay(true) == lived);
  // The received states made a difference.
  CHECK(replay(false) != lived);
}

TEST_CASE("peer: bodies that come and go while a replay is under way are none of its business",
          "[consensus][fault]") {
  Session session({.latency = 0.1, .jitter = 0.02});
  Site& a = session.add(1, 0.0, {}, kWeightless);
  Site& b = session.add(2, 0.003, {}, kWeightless);
  for (Site* site : {&a, &b}) site->share(ball(Vec3::Zero(), Vec3(0.3, 0.0, 0.0)));
  // In each step another one comes and is given a speed, and the oldest of eight goes.
  std::vector<pbd::BodyId> guests;
  a.user = [&](Site& site, SessionTime) {
    guests.push_back(
        site.world.add_body(ball(Vec3(0.0, 5.0, static_cast<double>(guests.size() % 16)))));
    for (const pbd::BodyId& guest : guests) {
      site.world.set_twist(guest, {Vec3(0.0, 0.1, 0.0), Vec3::Zero()});
      site.world.apply_force(guest, Vec3(0.0, 0.0, 0.1));
    }
    if (guests.size() <= 8) return;
    site.world.remove_body(guests.front());
    guests.erase(guests.begin());
  };
  b.user = [](Site& site, SessionTime) {
    site.world.set_twist(site.body, {Vec3(0.3, 0.05, 0.0), Vec3::Zero()});
  };
  session.run(3.0);
  CHECK(a.peer->stats().replay.fresh > 10);
  CHECK(a.x().allFinite());
  CHECK(gap_now(a, b) < 0.05);
}

}  // namespace
}  // namespace tandem::consensus::peer_replay_test
