// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sessions without a common time: stamps are read by when they come.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "consensus/crowd_fixture.h"
#include "consensus/random.h"
#include "support/catch.h"
#include "tandem/consensus/sender_clocks.h"

namespace tandem::consensus::dating_test {
namespace {

using namespace testing;

constexpr SessionTime kHour = 3'600'000'000'000;

/// Packets of one sender, 60 each second, by a clock that is `ahead` of the receiver's and drifts.
struct Stream {
  double there = 0.1235;  ///< s
  double back = 0.1235;   ///< s
  double jitter = 0.0;    ///< s, either way
  SessionTime ahead = 7 * kHour;
  double drift = 0.0;  ///< s per s
  SenderClocks clocks = {};
  Dice random{5};
  SessionTime now = kStart;  ///< of the receiver, when a packet leaves
  SessionTime shift = 0;

  SessionTime stamp() const {
    return now + ahead + std::llround(drift * static_cast<double>(now - kStart));
  }
  /// s, by how much what is stamped now would be dated wrongly; one packet later.
  double send(double late = 0.0) {
    const double delay = there + jitter * random.uniform(-1.0, 1.0) + late;
    shift = clocks.hear(2, stamp(), now + ns(delay), ns(there + back));
    const double error = 1e-9 * static_cast<double>(shifted(stamp(), shift) - now);
    now += ns(kTick);
    return error;
  }
};

TEST_CASE("timestamps: stamps of a steady link are dated exactly, but for half the asymmetry",
          "[consensus][analytic]") {
  Stream steady;
  Stream uneven{.there = 0.04, .back = 0.02};
  for (int i = 0; i < 300; ++i) {
    CHECK(steady.send() == Approx(0.0).margin(1e-8));
    CHECK(uneven.send() == Approx(0.01).margin(1e-8));
  }
}

TEST_CASE("timestamps: jitter is filtered, drift followed, time between stamps kept",
          "[consensus]") {
  Stream stream{.jitter = 0.005, .drift = 1e-4};
  double worst = 0.0;
  SessionTime before = 0;
  for (int i = 0; i < 3600; ++i) {
    const double error = stream.send();
    if (i > 180) worst = std::max(worst, std::abs(error));
    // Drift included; the first second follows at once.
    const auto most = ns(SenderClocks::kSlew * 1.4 * kTick);
    if (i > 62) CHECK(std::abs(stream.shift - before) <= most);
    before = stream.shift;
  }
  // A median of 128 of +-5 ms is 0.44 ms wide, and 100 ppm over its second and two of settling are
  // 0.3 ms.
  CHECK(worst < 1.5e-3);
}

TEST_CASE("timestamps: delayed packets move no clock, and a reset clock is found again",
          "[consensus]") {
  Stream stream;
  for (int i = 0; i < 120; ++i) stream.send();
  for (int i = 0; i < 30; ++i) CHECK(stream.send(3.0 - kTick * i) == Approx(0.0).margin(1e-8));
  for (int i = 0; i < 60; ++i) CHECK(stream.send() == Approx(0.0).margin(1e-8));
  for (const SessionTime step : {2 * kHour, -3 * kHour}) {
    stream.ahead += step;
    for (int i = 0; i < 70; ++i) stream.send();
    CHECK(stream.send() == Approx(0.0).margin(1e-8));
  }
}

TEST_CASE("timestamps: no number that is sent overflows", "[consensus][fault]") {
  constexpr SessionTime kMin = std::numeric_limits<SessionTime>::min();
  constexpr SessionTime kMax = std::numeric_limits<SessionTime>::max();
  const std::vector<SessionTime> stamps = {-kMaxStamp, kMaxStamp, 0, kStart, -1, kMaxStamp - 1};
  const std::vector<SessionTime> times = {kMin, kMax, 0, kStart, kMaxStamp, -kMaxStamp};
  const std::vector<SessionTime> ways = {-1, 0, kMax, kMin, kStart};
  SenderClocks clocks;
  Dice random(1);
  const auto pick = [&](const std::vector<SessionTime>& from) {
    const auto i = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(from.size())));
    return from[std::min(i, from.size() - 1)];
  };
  for (int i = 0; i < 20000; ++i) {
    const SessionTime stamp = pick(stamps);
    const SessionTime shift = clocks.hear(3, stamp, pick(times), pick(ways));
    const SessionTime dated = shifted(stamp, shift);
    REQUIRE(dated >= -kMaxStamp);
    REQUIRE(dated <= kMaxStamp);
    const SessionTime alone = SenderClocks::guess(stamp, pick(times), pick(ways));
    REQUIRE(shifted(stamp, alone) <= kMaxStamp);
  }
}

struct Outcome {
  double apart = 0.0;    ///< m, most while carried
  double settled = 0.0;  ///< m, some time after
};

/// Three peers, one of whom carries a ball around at 0.9 m/s.
/// @param hours  between their clocks, which drift by 100 ppm then
Outcome carry(const LinkOptions& there, const LinkOptions& back, TimestampSource timestamps,
              double hours) {
  Crowd crowd(there);
  crowd.build = build_table;
  const double slowest = -1e-4;
  for (PeerId id = 1; id <= 3; ++id) {
    const auto number = static_cast<double>(id - 1);
    const SessionTime ahead = ns(3600.0 * hours * number);
    const double drift = hours > 0.0 ? slowest * (number - 1.0) : 0.0;
    crowd.network.transport(id);
    crowd.network.set_clock(id, ahead, 1e6 * drift);
    PeerOptions options;
    options.timestamps = timestamps;
    crowd.add(id, options).clock = [=](SessionTime time) {
      return time + ahead + std::llround(drift * static_cast<double>(time - kStart));
    };
  }
  for (PeerId a = 1; a <= 3; ++a) {
    for (PeerId b = 1; b < a; ++b) crowd.network.set_link(a, b, back);
  }
  // The last one carries, so that it is not its clock by which time is told here.
  Member& user = crowd[2];
  Carrier carrier{.from = 0.5 + 3600.0 * hours * 2.0};
  bool carries = true;
  user.user = [&](Member& member, SessionTime now) {
    if (carries) carrier(member, now);
  };
  crowd.run(3.0);
  for (const auto& member : crowd.members) {
    if (timestamps == TimestampSource::Arrival || hours == 0.0) CHECK(member->tethers() == 1);
  }
  Outcome out;
  crowd.after = [&](Member&) { out.apart = std::max(out.apart, spread(crowd, kCarried)); };
  crowd.run(4.0);
  crowd.after = nullptr;
  carries = false;
  user.peer->release(carrier.grab);
  crowd.run(3.0);
  out.settled = std::max({spread(crowd, kCube), spread(crowd, kFree), spread(crowd, kCarried)});
  return out;
}

TEST_CASE("timestamps: with clocks hours apart copies agree as with a common one", "[consensus]") {
  const int profile = GENERATE(1, 3, 5);
  const LinkOptions link = network_profile(profile);
  const Outcome common = carry(link, link, TimestampSource::Sender, 0.0);
  const Outcome received = carry(link, link, TimestampSource::Arrival, 3.0);
  INFO("profile " << profile << ": " << 1e3 * common.apart << " mm, " << 1e3 * received.apart
                  << " mm on receipt; settled " << 1e3 * common.settled << ", "
                  << 1e3 * received.settled);
  // 1 ms of jitter that is left, at 0.9 m/s, and what it makes of the hand's acceleration.
  CHECK(received.apart < 1.05 * common.apart + 1e-3);
  CHECK(received.settled < common.settled + 1e-3);
  // Else nothing is shown by it. (Hours would be told from ways.)
  CHECK(carry(link, link, TimestampSource::Sender, 2.0 / 3600.0).apart > 2.0 * received.apart);
}

TEST_CASE("timestamps: unequal ways cost half of their difference in time", "[consensus]") {
  LinkOptions there;
  there.latency = 0.06;
  LinkOptions back;
  back.latency = 0.02;
  const Outcome common = carry(there, back, TimestampSource::Sender, 0.0);
  const Outcome received = carry(there, back, TimestampSource::Arrival, 3.0);
  INFO(1e3 * common.apart << " mm, " << 1e3 * received.apart << " mm on receipt");
  // 20 ms at 0.9 m/s, and at 2.7 m/s^2 over the spring's 0.1 s.
  CHECK(received.apart < common.apart + 0.02 * (0.9 + 0.27));
  // Copies that rest within 1 mm of each of the others' are let sleep.
  CHECK(received.settled < 2e-3);
}

TEST_CASE("timestamps: farewells and silence end the holds of a peer with another clock",
          "[consensus]") {
  const bool says_so = GENERATE(true, false);
  Crowd crowd(network_profile(4));
  crowd.build = build_table;
  PeerOptions options;
  options.timestamps = TimestampSource::Arrival;
  for (PeerId id = 1; id <= 3; ++id) {
    const SessionTime ahead = static_cast<SessionTime>(id - 1) * kHour;
    crowd.network.transport(id);
    crowd.network.set_clock(id, ahead);
    crowd.add(id, options).clock = [ahead](SessionTime time) { return time + ahead; };
  }
  Carrier carrier{.from = 0.5 + 7200.0};
  crowd[2].user = [&](Member& member, SessionTime now) { carrier(member, now); };
  crowd.run(3.0);
  CHECK(crowd[0].tethers() == 1);
  if (says_so) crowd[2].peer->leave(crowd[2].clock(crowd.now()));
  crowd.crash(crowd[2]);
  crowd.run(says_so ? 0.2 : PeerOptions{}.spring_timeout + 0.2);
  CHECK(crowd[0].tethers() == 0);
  CHECK(crowd[1].tethers() == 0);
  // Its clock begins somewhere else, as after a restart of the machine.
  const SessionTime ahead = says_so ? 5 * kHour : kHour / 2;
  crowd.network.set_clock(3, ahead);
  crowd[2].clock = [ahead](SessionTime time) { return time + ahead; };
  crowd[2].user = nullptr;
  crowd.restart(crowd[2]);
  crowd.run(2.5);
  crowd[2].peer->grab({.body = crowd[2].bodies[kCarried].id,
                       .anchor_w = crowd[2].x(kCarried) + Vec3(0.0, 0.0, 0.4),
                       .stiffness = 300.0,
                       .damping = 25.0,
                       .max_force = 50.0});
  crowd.run(2.0);
  CHECK(crowd[0].tethers() == 1);
  CHECK(crowd[0].x(kCarried).z() > 0.3);
  CHECK(spread(crowd, kCarried) < 2e-3);
}

}  // namespace
}  // namespace tandem::consensus::dating_test
