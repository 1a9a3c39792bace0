// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What networks and clocks do to a session: it stays stable, the error bounded, springs the same.
#include <algorithm>
#include <cmath>

#include "consensus/crowd_fixture.h"
#include "support/catch.h"

namespace tandem::consensus::network_fault_test {
namespace {

using namespace testing;

struct Outcome {
  double carried = 0.0;  ///< m, largest distance of the carried body's copies after 2 s
  double resting = 0.0;  ///< m, of the cube's
  double fastest = 0.0;  ///< m/s
  double high = 0.0;     ///< m, highest point of any carried copy
  double settled = 0.0;  ///< m, some seconds after the carrier has let go
  bool springs = true;   ///< all copies held by one spring to the end of the lift
};

/// Three peers, one of whom carries a body for 8 s and puts it down.
Outcome carry(const LinkOptions& link, const PeerOptions& options = {},
              const std::function<void(Crowd&)>& upset = {}, double rest = 4.0) {
  Crowd crowd(link, 5);
  crowd.build = build_table;
  for (PeerId id = 1; id <= 3; ++id) crowd.add(id, options);
  Carrier carrier;
  bool let_go = false;
  crowd[0].user = [&](Member& member, SessionTime now) {
    if (!let_go) carrier(member, now);
  };
  Outcome outcome;
  crowd.after = [&](Member& member) {
    const bool begun = member.next > kStart + ns(3.0);
    if (begun && !let_go) outcome.carried = std::max(outcome.carried, spread(crowd, kCarried));
    outcome.resting = std::max(outcome.resting, spread(crowd, kCube));
    for (std::size_t body = 0; body < 3; ++body) {
      REQUIRE(member.x(body).allFinite());
      outcome.fastest = std::max(outcome.fastest, member.v(body).norm());
    }
    outcome.high = std::max(outcome.high, member.x(kCarried).z());
  };
  if (upset) upset(crowd);
  crowd.run(8.0);
  for (const auto& member : crowd.members) {
    outcome.springs = outcome.springs && member->tethers() == 1;
  }
  let_go = true;
  crowd[0].peer->release(carrier.grab);
  crowd.run(rest);
  for (const auto& member : crowd.members) {
    outcome.springs = outcome.springs && member->tethers() == 0;
  }
  outcome.settled = std::max(spread(crowd, kCarried), spread(crowd, kCube));
  UNSCOPED_INFO("carried " << 1e3 * outcome.carried << " mm apart, resting "
                           << 1e3 * outcome.resting << " mm, settled " << 1e3 * outcome.settled
                           << " mm, fastest " << outcome.fastest << " m/s, highest " << outcome.high
                           << " m");
  return outcome;
}

/// Carried at 0.9 m/s, half a metre up: what no fault may change.
void check_sane(const Outcome& outcome, double apart) {
  CHECK(outcome.springs);
  CHECK(outcome.carried < apart);
  CHECK(outcome.resting < 1e-3);
  CHECK(outcome.settled < 5e-3);
  CHECK(outcome.fastest < 5.0);
  CHECK(outcome.high < 0.9);
}

TEST_CASE("network: small shares bear 1 s of latency, 100 ms of jitter, a quarter lost and twice",
          "[consensus][fault]") {
  LinkOptions link;
  link.latency = 1.0;
  link.jitter = 0.1;
  link.loss = 0.25;
  link.duplicate = 0.25;
  PeerOptions options;
  // States that are a second old on arrival must not have expired, and cannot be followed quickly.
  options.influence.max_age = 3.0;
  options.spring_timeout = 4.0;
  options.influence.baseline = options.influence.leading = 0.02;
  // A hand that turns at 3 rad/s is a diameter of its circle elsewhere after a second.
  const Outcome outcome = carry(link, options, {}, 30.0);
  CHECK(outcome.springs);
  CHECK(outcome.carried < 1.0);
  CHECK(outcome.resting < 1e-3);
  CHECK(outcome.settled < 0.05);
  CHECK(outcome.fastest < 5.0);
  CHECK(outcome.high < 0.9);
}

TEST_CASE("network: bursts of loss, losses, reordering", "[consensus][fault]") {
  LinkOptions link = network_profile(3);
  link.loss = 0.25;
  link.reorder = 0.25;
  link.reorder_delay = 0.1;
  link.duplicate = 0.1;
  link.bursts = 0.5;
  link.burst_length = 0.25;
  check_sane(carry(link), 0.5);
}

TEST_CASE("network: delays that differ by direction", "[consensus][fault]") {
  check_sane(carry(network_profile(1), {},
                   [](Crowd& crowd) {
                     for (PeerId to = 2; to <= 3; ++to) {
                       crowd.network.set_link(1, to, network_profile(5));
                     }
                   }),
             0.12);
}

TEST_CASE("network: 64 kbit/s", "[consensus][fault]") {
  // Three states take 300 bytes, 60 times a second: twice what there is. The queue is as long as
  // the application says; 1 KiB of it is an eighth of a second.
  LinkOptions link = network_profile(3);
  link.bandwidth = 64e3;
  link.queue_limit = 1024;
  check_sane(carry(link), 0.3);
}

TEST_CASE("network: a clock that is a second off for a while, and ones that drift",
          "[consensus][fault]") {
  const double by = GENERATE(1.0, -1.0);
  const std::size_t whose = GENERATE(std::size_t{0}, std::size_t{1});
  INFO("peer " << whose + 1 << " by " << by << " s");
  const Outcome outcome = carry(network_profile(2), {}, [&](Crowd& crowd) {
    crowd[whose].clock = [by](SessionTime now) {
      const bool wrong = now > kStart + ns(4.0) && now < kStart + ns(5.5);
      return wrong ? now + ns(by) : now;
    };
  });
  CHECK(outcome.fastest < 6.0);
  CHECK(outcome.high < 1.0);
  CHECK(outcome.resting < 1e-3);
  CHECK(outcome.settled < 5e-3);
  CHECK(outcome.carried < 0.8);
}

TEST_CASE("network: a clock that runs 100 ppm fast", "[consensus][fault]") {
  // 0.8 ms after 8 s, at 0.9 m/s and 2.7 m/s^2.
  check_sane(carry(network_profile(2), {},
                   [](Crowd& crowd) {
                     crowd[1].clock = [](SessionTime now) { return now + (now - kStart) / 10'000; };
                   }),
             0.03);
}

}  // namespace
}  // namespace tandem::consensus::network_fault_test
