// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bytes from peers are untrusted: what is refused is counted and moves nothing, what is believed
// moves bodies no further than it should.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "consensus/peer_fixture.h"
#include "consensus/stub_transport.h"
#include "consensus/updates.h"
#include "support/catch.h"

namespace tandem::consensus::peer_fault_test {
namespace {

using namespace testing;
using Bytes = std::vector<std::byte>;

constexpr double kFrame = 1.0 / 60.0;
constexpr PeerId kVictim = 5;

/// A victim whose transport the test feeds, and a control that hears nothing of it.
class Duel {
 public:
  explicit Duel(std::optional<PeerId> owner = std::nullopt, const pbd::WorldDef& def = {}) {
    for (Side* side : {&victim_, &control_}) {
      side->site = std::make_unique<Site>(side->transport, PeerOptions{}, def);
      side->site->share(cube({0.0, 0.0, kHalf.z()}), owner);
      if (def.gravity.norm() > 0.0) put_on_plane(*side->site);
    }
  }
  Site& victim() { return *victim_.site; }
  const Site& control() const { return *control_.site; }
  StubTransport& line() { return victim_.transport; }
  const PeerStats& stats() { return victim().peer->stats(); }
  SessionTime now() const { return now_; }

  /// Steps of both, each after `attack`.
  template <class Attack>
  void run(int steps, Attack&& attack) {
    for (int i = 0; i < steps; ++i) {
      attack(i);
      for (Side* side : {&victim_, &control_}) {
        side->site->peer->before_step(now_);
        side->site->solver.step(side->site->world, kFrame);
        side->site->peer->after_step(now_ + ns(kFrame));
      }
      now_ += ns(kFrame);
      untouched_ = untouched_ && victim().world.hash() == control().world.hash();
    }
  }
  void run(int steps) {
    run(steps, [](int) {});
  }
  /// Whether the victim's world never differed from the control's by a bit.
  bool untouched() const { return untouched_; }

  /// The state that a peer in agreement would send, moved by an offset.
  StateUpdate state(const Vec3& offset, float influence) const {
    StateUpdate update;
    update.id = kBody;
    update.pose = control().pose();
    update.pose.position += offset;
    update.influence = influence;
    update.stamp = now_;
    return update;
  }

 private:
  struct Side {
    StubTransport transport{kVictim};
    std::unique_ptr<Site> site;
  };
  Side victim_;
  Side control_;
  SessionTime now_ = kStart;
  bool untouched_ = true;
};

TEST_CASE("peer: a hostile stream of bytes moves nothing, its sender is dropped with a reason",
          "[consensus][fault]") {
  Duel duel;
  Dice dice(3);
  std::uint64_t sent = 0;
  const auto send = [&](Bytes bytes) {
    duel.line().inbox.push_back({2, std::move(bytes)});
    ++sent;
  };
  const auto valid = [&] {
    Bytes bytes;
    const StateUpdate update = duel.state({0.1, 0.0, 0.0}, 0.1f);
    encode(std::span(&update, 1), bytes);
    return bytes;
  };
  duel.run(60, [&](int i) {
    Bytes random(1 + dice.below(300));
    for (std::byte& byte : random) byte = static_cast<std::byte>(dice.bits());
    // A random packet that begins like a real one is the harder test.
    Bytes begun = valid();
    begun.resize(kHeaderBytes);
    begun.insert(begun.end(), random.begin(), random.end());
    Bytes truncated = valid();
    truncated.resize(dice.below(truncated.size()));
    Bytes version = valid();
    version[2] = static_cast<std::byte>(kPacketVersion + 1 + dice.below(200));
    Bytes count = valid();
    count[4] = count[5] = std::byte{0xff};
    Bytes oversized = valid();
    while (oversized.size() <= kMaxPacketBytes) {
      const Bytes more = valid();
      oversized.insert(oversized.end(), more.begin(), more.end());
    }
    // The position, three 64-bit floats, follows the 16 bytes of the id.
    Bytes not_finite = valid();
    const double nan = i % 2 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                  : std::numeric_limits<double>::infinity();
    std::memcpy(not_finite.data() + kHeaderBytes + 16 + 8 * dice.below(3), &nan, 8);
    for (Bytes* bytes : {&random, &begun, &truncated, &version, &count, &oversized, &not_finite}) {
      send(std::move(*bytes));
    }
  });
  CHECK(duel.untouched());
  CHECK(duel.stats().packets_received == sent);
  CHECK(duel.stats().packets_rejected == sent);
  CHECK(duel.stats().updates_received == 0);
  REQUIRE(duel.line().dropped.size() == sent);
  for (const auto& [peer, reason] : duel.line().dropped) {
    CHECK(peer == 2);
    CHECK(reason.size() > std::string("undecodable packet: ").size());
  }
  // The same bytes unharmed do move it, so the control would have shown.
  send(valid());
  duel.run(1);
  CHECK_FALSE(duel.untouched());
}

TEST_CASE("peer: the network drops a peer that sends undecodable packets", "[consensus][fault]") {
  Session session;
  Site& victim = session.add(1, 0.0, {}, kWeightless);
  victim.share(ball(Vec3::Zero()));
  Transport& hostile = session.network.transport(2);
  session.run(0.1);
  hostile.post(1, Bytes(30, std::byte{7}), Delivery::Newest);
  session.run(0.1);
  const auto status = session.network.transport(1).peers();
  REQUIRE(status.size() == 1);
  CHECK_FALSE(status[0].connected);
  CHECK(status[0].reason.find("undecodable packet: byte 0") == 0);
  CHECK_FALSE(hostile.post(1, Bytes(30, std::byte{7}), Delivery::Newest));
}

TEST_CASE("peer: decodable packets that do not apply are counted and move nothing",
          "[consensus][fault]") {
  Duel duel;
  const Vec3 far(0.1, 0.0, 0.0);
  duel.run(30, [&](int) {
    StateUpdate unknown = duel.state(far, 0.1f);
    unknown.id = SharedId::from_name("nobody's");
    duel.line().deliver(2, unknown);
    StateUpdate future = duel.state(far, 0.1f);
    future.stamp += ns(1.1);
    duel.line().deliver(2, future);
    StateUpdate endless = duel.state(far, 0.1f);
    endless.stamp = kMaxStamp - 1;
    duel.line().deliver(2, endless);
    StateUpdate old = duel.state(far, 0.1f);
    old.stamp -= ns(1.1);
    duel.line().deliver(2, old);
    StateUpdate silent = duel.state(far, 0.0f);
    duel.line().deliver(3, silent);
    SpringUpdate spring{.spring = 1,
                        .revision = 1,
                        .body = SharedId::from_name("nobody's"),
                        .stiffness = 1e3,
                        .damping = 1.0,
                        .max_force = 1e3,
                        .stamp = duel.now()};
    duel.line().deliver(2, spring);
  });
  CHECK(duel.untouched());
  CHECK(duel.stats().packets_rejected == 0);
  CHECK(duel.stats().unknown_ids == 30);
  CHECK(duel.stats().inbox.unknown_id == 30);
  CHECK(duel.stats().inbox.future == 60);
  CHECK(duel.stats().inbox.expired == 30);
  CHECK(duel.stats().springs_refused == 30);
  CHECK(duel.victim().tethers().size() == 0);
  CHECK(duel.line().dropped.empty());
}

TEST_CASE("peer: a claim to a body without owner gives no ownership", "[consensus][fault]") {
  // No more than half of the gap in 1/60 s, where an owner gets all of it.
  const Vec3 offset(0.1, 0.0, 0.0);
  const auto moved_by = [&](std::optional<PeerId> owner, bool claims_hand) {
    Duel duel(owner, kWeightless);
    duel.run(90);  // past the ramp
    StateUpdate update = duel.state(offset, 1.0f);
    update.flags.owner_driven = claims_hand;
    duel.line().deliver(2, update);
    duel.run(1);
    return duel.victim().x().x() / offset.x();
  };
  CHECK(moved_by(std::nullopt, false) <= 0.5 + 1e-9);
  CHECK(moved_by(std::nullopt, true) <= 0.5 + 1e-9);
  CHECK(moved_by(std::nullopt, false) > 0.08);
  CHECK(moved_by(PeerId{2}, true) == Approx(1.0).epsilon(1e-9));
}

TEST_CASE("peer: states of an owned body count from its owner only", "[consensus][fault]") {
  const PeerId owner = GENERATE(PeerId{3}, kVictim);
  Duel duel(owner);
  duel.run(60, [&](int) {
    StateUpdate update = duel.state({0.1, 0.0, 0.1}, 1.0f);
    update.flags.owner_driven = true;
    duel.line().deliver(2, update);
  });
  CHECK(duel.untouched());
  CHECK(duel.stats().updates_received == 60);
}

TEST_CASE("peer: late states of a peer that has left move nothing", "[consensus][fault]") {
  Duel duel({}, kWeightless);
  duel.run(90);
  // Its clock is a little ahead of ours.
  duel.line().deliver(2, Leave{.stamp = duel.now() + ns(0.03)});
  duel.run(1);
  duel.run(5, [&](int i) {
    StateUpdate update = duel.state({0.1, 0.0, 0.0}, 0.1f);
    update.stamp = kStart + ns(90 * kFrame) + ns(0.02) + i;
    duel.line().deliver(2, update);
  });
  CHECK(duel.untouched());
  // Back again, it is heard.
  duel.line().deliver(2, duel.state({0.1, 0.0, 0.0}, 0.1f));
  duel.run(1);
  CHECK_FALSE(duel.untouched());
}

TEST_CASE("peer: made-up ids fill no memory and push out no active peer", "[consensus][fault]") {
  Duel duel({}, kWeightless);
  duel.run(90, [&](int) { duel.line().deliver(2, duel.state(Vec3::Zero(), 0.1f)); });
  PeerId invented = 1000;
  duel.run(100, [&](int) {
    duel.line().deliver(2, duel.state(Vec3::Zero(), 0.1f));
    for (int i = 0; i < 100; ++i) {
      StateUpdate update = duel.state(Vec3::Zero(), 0.1f);
      update.id = {7, ++invented};  // a body that nobody has
      duel.line().deliver(invented, update);
    }
  });
  const auto reports = duel.victim().peer->reports();
  CHECK(reports.size() <= 1024);
  REQUIRE(std::ranges::find(reports, PeerId{2}, &PeerReport::peer) != reports.end());
  CHECK(std::ranges::find(reports, PeerId{2}, &PeerReport::peer)->inbox.accepted == 190);
  // It is heard as before.
  duel.line().deliver(2, duel.state({0.1, 0.0, 0.0}, 0.1f));
  duel.run(1);
  CHECK_FALSE(duel.untouched());
}

TEST_CASE("peer: springs of any strength that a packet can name leave a finite world",
          "[consensus][fault]") {
  Duel duel({}, kWeightless);
  Dice dice(5);
  std::uint32_t number = 0;
  for (const double stiffness : {1e-9, 1e3, 0.99e12}) {
    for (const double damping : {0.0, 0.99e12}) {
      for (const double force : {1e-9, 0.99e12}) {
        SpringUpdate spring{.spring = ++number,
                            .revision = 1,
                            .body = kBody,
                            .attachment_l = dice.vec3(10.0),
                            .anchor_w = dice.vec3(50.0),  // further ones are refused
                            .anchor_velocity = dice.vec3(1e4),
                            .stiffness = stiffness,
                            .damping = damping,
                            .max_force = force,
                            .stamp = duel.now()};
        duel.line().deliver(2, spring);
      }
    }
  }
  duel.run(20);
  CHECK(duel.stats().packets_rejected == 0);
  CHECK(duel.victim().tethers().size() == static_cast<int>(number));
  CHECK(duel.victim().x().allFinite());
  CHECK(duel.victim().v().allFinite());
  CHECK(duel.victim().pose().orientation.coeffs().allFinite());
}

TEST_CASE("peer: sharing a fixed or an already shared body is refused", "[consensus][fault]") {
  StubTransport transport(1);
  Site site(transport, {}, kWeightless);
  site.share(ball(Vec3::Zero()));
  const pbd::BodyId wall = site.world.add_body({.type = pbd::BodyType::Static});
  CHECK_THROWS_WITH(site.peer->share({.id = SharedId::from_name("wall"), .body = wall}),
                    Catch::Contains("static"));
  CHECK_THROWS_WITH(site.peer->share({.id = SharedId::from_name("again"), .body = site.body}),
                    Catch::Contains("one id only"));
}

TEST_CASE("peer: a leader that nobody can follow does not become an owner", "[consensus][fault]") {
  // A lower id insists on an orientation a right angle away for ten seconds. The share that it is
  // given grows, and stays a share: an owner's would be 1.
  StubTransport transport(2);
  Site site(transport, {.authority_ramp = 0.0}, kWeightless);
  site.share(cube(Vec3::Zero()));
  for (int i = 0; i < 600; ++i) {
    const SessionTime now = kStart + i * ns(1.0 / 60.0);
    StateUpdate update{.id = kBody, .influence = 0.5F, .stamp = now};
    update.pose.orientation = Quat(Eigen::AngleAxisd(1.5, Vec3::UnitZ()));
    transport.deliver(1, update);
    site.peer->before_step(now);
    std::vector<pbd::PoseTarget> targets;
    site.peer->collect(site.world, 1.0 / 60.0, {}, targets);
    for (const pbd::PoseTarget& target : targets) CHECK(target.share <= 0.5 + 1e-12);
    site.peer->after_step(now + ns(1.0 / 60.0));  // wedged: no solver turns it
  }
}

}  // namespace
}  // namespace tandem::consensus::peer_fault_test
