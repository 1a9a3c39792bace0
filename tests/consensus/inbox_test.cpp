// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "receive/inbox.h"

#include <algorithm>
#include <array>
#include <limits>

#include "consensus/random.h"
#include "support/catch.h"

namespace inbox_test {

using namespace tandem::consensus;
using tandem::consensus::testing::Dice;

namespace {

constexpr SessionTime kMs = 1'000'000;
constexpr SessionTime kNow = 1'000'000 * kMs;
const SharedId kCube{0, 1};
const SharedId kBall{0, 2};

/// A state of `id` stamped `age_ms` before kNow; x tells updates apart.
StateUpdate state(const SharedId& id, SessionTime age_ms, double x = 0.0) {
  StateUpdate update;
  update.id = id;
  update.stamp = kNow - age_ms * kMs;
  update.pose.position.x() = x;
  return update;
}

/// Positions number the states here, and nothing moves like that.
Inbox two_by_two() {
  Inbox inbox({.plausibility = {.jump = 1e9}});
  inbox.add_id(kBall);
  inbox.add_id(kCube);
  inbox.add_peer(20);
  inbox.add_peer(10);
  return inbox;
}

}  // namespace

TEST_CASE("inbox: the newest update of each peer is kept, by ascending peer", "[consensus][unit]") {
  Inbox inbox = two_by_two();
  CHECK(inbox.offer(20, state(kCube, 30, 1.0), kNow) == InboxVerdict::Accepted);
  CHECK(inbox.offer(10, state(kCube, 40, 2.0), kNow) == InboxVerdict::Accepted);
  CHECK(inbox.offer(20, state(kCube, 10, 3.0), kNow + kMs) == InboxVerdict::Accepted);

  const auto kept = inbox.newest(kCube);
  REQUIRE(kept.size() == 2);
  CHECK(kept[0].peer == 10);
  CHECK(kept[0].update.pose.position.x() == 2.0);
  CHECK(kept[1].peer == 20);
  CHECK(kept[1].update.pose.position.x() == 3.0);
  CHECK(kept[1].arrival == kNow + kMs);
  CHECK(inbox.newest(kBall).empty());
}

TEST_CASE("inbox: late and duplicate updates change nothing and are counted", "[consensus][unit]") {
  Inbox inbox = two_by_two();
  inbox.offer(10, state(kCube, 20, 1.0), kNow);
  CHECK(inbox.offer(10, state(kCube, 20, 2.0), kNow) == InboxVerdict::Duplicate);
  CHECK(inbox.offer(10, state(kCube, 21, 3.0), kNow) == InboxVerdict::Late);
  CHECK(inbox.newest(kCube)[0].update.pose.position.x() == 1.0);
  // Another body and another peer have nothing to do with it.
  CHECK(inbox.offer(10, state(kBall, 21), kNow) == InboxVerdict::Accepted);
  CHECK(inbox.offer(20, state(kCube, 21), kNow) == InboxVerdict::Accepted);
  CHECK(inbox.counters(10) == InboxCounters{2, 1, 1, 0, 0, 0, 0});
  CHECK(inbox.counters(20) == InboxCounters{1, 0, 0, 0, 0, 0, 0});
  CHECK(inbox.totals() == InboxCounters{3, 1, 1, 0, 0, 0, 0});
  CHECK(inbox.totals().dropped() == 2);
}

TEST_CASE("inbox: stamps beyond the limits are refused, those at the limits are not",
          "[consensus][unit]") {
  InboxOptions options;
  options.max_age = 0.5;
  options.max_future = 0.25;
  Inbox inbox(options);
  inbox.add_id(kCube);
  inbox.add_peer(1);
  StateUpdate update = state(kCube, 500);
  update.stamp -= 1;
  CHECK(inbox.offer(1, update, kNow) == InboxVerdict::Expired);
  update.stamp += 1;
  CHECK(inbox.offer(1, update, kNow) == InboxVerdict::Accepted);
  update = state(kCube, -250);
  update.stamp += 1;
  CHECK(inbox.offer(1, update, kNow) == InboxVerdict::Future);
  update.stamp -= 1;
  CHECK(inbox.offer(1, update, kNow) == InboxVerdict::Accepted);
  CHECK(inbox.totals() == InboxCounters{2, 0, 0, 1, 1, 0, 0});
}

TEST_CASE("inbox: a stamp at the end of the range is refused like any other",
          "[consensus][fault]") {
  Inbox inbox = two_by_two();
  StateUpdate update = state(kCube, 0);
  update.stamp = std::numeric_limits<SessionTime>::max();
  CHECK(inbox.offer(10, update, kNow) == InboxVerdict::Future);
  update.stamp = std::numeric_limits<SessionTime>::min();
  CHECK(inbox.offer(10, update, kNow) == InboxVerdict::Expired);
}

TEST_CASE("inbox: unknown ids and peers leave no trace but a count", "[consensus][fault]") {
  Inbox inbox = two_by_two();
  Dice dice(3);
  for (int i = 0; i < 1000; ++i) {
    const SharedId id{dice.bits() | 1, dice.bits()};
    CHECK(inbox.offer(10, state(id, 0), kNow) == InboxVerdict::UnknownId);
    CHECK(inbox.newest(id).empty());
    CHECK(inbox.offer(100 + dice.below(1000), state(kCube, 0), kNow) == InboxVerdict::UnknownPeer);
  }
  CHECK(inbox.id_count() == 2);
  CHECK(inbox.newest(kCube).empty());
  CHECK(inbox.totals().unknown_id == 1000);
  CHECK(inbox.totals().unknown_peer == 1000);
  CHECK(inbox.counters(10).unknown_id == 1000);
  CHECK(inbox.counters(100) == InboxCounters{});
}

TEST_CASE("inbox: the order of arrival does not change which updates are kept",
          "[consensus][unit]") {
  struct Offer {
    PeerId peer;
    StateUpdate update;
  };
  std::vector<Offer> offers;
  for (const PeerId peer : {PeerId{10}, PeerId{20}}) {
    for (const SharedId& id : {kCube, kBall}) {
      for (int age = 0; age < 20; ++age) offers.push_back({peer, state(id, 7 + age, age)});
    }
  }
  Dice dice(5);
  for (int round = 0; round < 50; ++round) {
    for (std::size_t i = offers.size(); i > 1; --i) std::swap(offers[i - 1], offers[dice.below(i)]);
    Inbox inbox = two_by_two();
    for (const Offer& offer : offers) inbox.offer(offer.peer, offer.update, kNow);
    for (const SharedId& id : {kCube, kBall}) {
      const auto kept = inbox.newest(id);
      REQUIRE(kept.size() == 2);
      CHECK(kept[0].peer == 10);
      CHECK(kept[1].peer == 20);
      CHECK(kept[0].update.pose.position.x() == 0.0);
      CHECK(kept[1].update.pose.position.x() == 0.0);
    }
    CHECK(inbox.totals().accepted + inbox.totals().late == offers.size());
  }
}

TEST_CASE("inbox: a peer that left is forgotten, and starts anew when it comes back",
          "[consensus][unit]") {
  Inbox inbox = two_by_two();
  inbox.offer(10, state(kCube, 0), kNow);
  inbox.offer(20, state(kCube, 0), kNow);
  inbox.remove_peer(10);
  REQUIRE(inbox.newest(kCube).size() == 1);
  CHECK(inbox.newest(kCube)[0].peer == 20);
  CHECK(inbox.offer(10, state(kCube, 0), kNow) == InboxVerdict::UnknownPeer);
  CHECK(inbox.counters(10).accepted == 1);
  inbox.add_peer(10);
  // Older than what it had sent before it left: the new process has its own clock.
  CHECK(inbox.offer(10, state(kCube, 50), kNow) == InboxVerdict::Accepted);
  inbox.remove_peer(99);
}

TEST_CASE("inbox: bodies can be removed and expired states pruned", "[consensus][unit]") {
  Inbox inbox = two_by_two();
  inbox.offer(10, state(kCube, 0), kNow);
  inbox.offer(20, state(kCube, 900), kNow);
  inbox.offer(10, state(kBall, 0), kNow);
  CHECK(inbox.prune(kNow + 100 * kMs) == 0);
  CHECK(inbox.prune(kNow + 101 * kMs) == 1);
  REQUIRE(inbox.newest(kCube).size() == 1);
  CHECK(inbox.newest(kCube)[0].peer == 10);
  inbox.remove_id(kCube);
  CHECK(inbox.id_count() == 1);
  CHECK(inbox.newest(kCube).empty());
  CHECK(inbox.offer(10, state(kCube, -1), kNow) == InboxVerdict::UnknownId);
}

TEST_CASE("inbox: a resting state holds while its sender is connected", "[consensus][unit]") {
  Inbox inbox = two_by_two();
  StateUpdate rests = state(kCube, 100);
  rests.flags.resting = true;
  inbox.offer(10, rests, kNow);
  inbox.offer(10, state(kBall, 100), kNow);
  inbox.offer(20, rests, kNow);
  const auto holds_until = [&](std::size_t peer) {
    return inbox.holds_until(inbox.newest(kCube)[peer]);
  };
  CHECK(holds_until(0) == rests.stamp);
  CHECK_FALSE(inbox.note_alive(10, kNow, kNow + kMs));
  CHECK_FALSE(inbox.note_alive(10, kNow - 50 * kMs, kNow + kMs));  // overtaken
  CHECK(holds_until(0) == kNow);
  CHECK(holds_until(1) == rests.stamp);                                  // another peer's
  CHECK(inbox.holds_until(inbox.newest(kBall)[0]) == kNow - 100 * kMs);  // it moves
  inbox.note_alive(10, kNow + 3000 * kMs, kNow);                         // nobody is so far ahead
  CHECK(holds_until(0) == kNow);

  // The default of max_age is one second.
  CHECK_FALSE(inbox.note_alive(10, kNow + 800 * kMs, kNow + 850 * kMs));
  CHECK(inbox.prune(kNow + 1500 * kMs) == 2);  // all that peer 20 said, and what moves
  REQUIRE(inbox.newest(kCube).size() == 1);
  CHECK(inbox.newest(kCube)[0].peer == 10);
  CHECK(inbox.newest(kBall).empty());
  CHECK(inbox.prune(kNow + 1900 * kMs) == 1);  // silent for longer than that
  CHECK(inbox.note_alive(10, kNow + 1880 * kMs, kNow + 1900 * kMs));
  CHECK_FALSE(inbox.note_alive(10, kNow + 1890 * kMs, kNow + 1900 * kMs));
  // Said once and late: better than nothing.
  rests.stamp = kNow;
  CHECK(inbox.offer(10, rests, kNow + 2000 * kMs) == InboxVerdict::Accepted);
  CHECK(holds_until(0) == kNow + 1890 * kMs);
  CHECK(inbox.offer(10, state(kBall, 0), kNow + 2000 * kMs) == InboxVerdict::Expired);
}

}  // namespace inbox_test
