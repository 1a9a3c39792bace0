// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One member whose states are old, true or false, beside some who are near each other. The others
// do to the bit what they do without it.
#include <algorithm>
#include <string>

#include "company.h"
#include "demos/runs.h"
#include "runner/virtual_session.h"
#include "scenes/scenario_list.h"
#include "support/catch.h"

namespace tandem::demos::late_member_test {
namespace {

using consensus::PeerId;

TEST_CASE("late member: nobody else moves otherwise, or pays for it", "[demos]") {
  const auto [honest, profile] = GENERATE(table<int, int>({{2, 1}, {2, 5}, {3, 3}, {6, 3}}));
  const Company company{.honest = honest, .profile = profile, .seconds = 4.0};
  const Outcome alone = run(company, nullptr);
  for (const Saying& saying :
       {Saying{.age = 0.84}, Saying{.age = 0.84, .influence = 1e-30, .bodies = 1},
        Saying{.age = 0.4, .influence = 1.0, .leads = true}, Saying{.age = 0.5, .aside = 0.3},
        Saying{.age = 0.3, .other_age = 0.8, .every = 20}}) {
    CAPTURE(honest, profile, saying.age, saying.influence, saying.aside, saying.every);
    const Outcome beside = run(company, &saying);
    CHECK(beside.worlds == alone.worlds);
    REQUIRE(beside.late.size() == alone.worlds.size());
    for (std::size_t i = 0; i < alone.worlds.size(); ++i) {
      CHECK(beside.replays[i].steps == alone.replays[i].steps);
      CHECK(beside.replays[i].without == alone.replays[i].without);
      CHECK(beside.late[i] > 60);
      CHECK(beside.without[i] == 0);
    }
  }
}

TEST_CASE("late member: of two others the older one costs no replay that goes back to it",
          "[demos]") {
  const auto seed = GENERATE(std::uint64_t{1}, std::uint64_t{2}, std::uint64_t{3});
  const Company company{.honest = 2, .profile = 2, .seconds = 6.0, .seed = seed};
  const Outcome alone = run(company, nullptr);
  for (const Saying& saying : {Saying{.age = 0.1, .influence = 0.12}, Saying{.age = 0.15},
                               Saying{.age = 0.17, .influence = 0.9, .aside = 0.035}}) {
    CAPTURE(seed, saying.age, saying.aside, alone.p50, alone.p95);
    const Outcome beside = run(company, &saying);
    CHECK(beside.p50 < 1.25 * alone.p50);
    CHECK(static_cast<double>(beside.body_steps) < 1.3 * static_cast<double>(alone.body_steps));
    for (std::size_t i = 0; i < alone.replays.size(); ++i) {
      CHECK(beside.replays[i].without == alone.replays[i].without);
    }
  }
}

TEST_CASE("late member: no replay is made for a member without votes left", "[demos]") {
  // At the age of the others' news, and far from them.
  const Company company{.honest = 2, .profile = 5, .seconds = 4.0};
  const Outcome alone = run(company, nullptr);
  const Saying saying{.age = 0.02, .influence = 0.9, .aside = 0.8, .bodies = 1, .leads = true};
  const Outcome beside = run(company, &saying);
  CHECK(beside.worlds == alone.worlds);
}

TEST_CASE("late member: a far peer follows, and the near ones are as without it", "[demos]") {
  const auto scenario = make_scenario("cubes");
  DemoOptions options = quiet(3, 5.0);
  options.peers = 3;
  VirtualSession session(*scenario, options, nullptr);
  consensus::LinkOptions far = options.link_options();
  far.latency = 0.6;
  for (const PeerId near : {1, 2}) {
    session.network().set_link(near, 3, far);
    session.network().set_link(3, near, far);
  }
  while (session.act(kVirtualStart + 5'000'000'000)) {
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const consensus::PeerStats& stats = session.actors()[i].participant().peer().stats();
    CHECK(stats.replay.without <= 3);
    // As many as news from the near one are old, at the most.
    CHECK(stats.replay.steps < 3 * 5 * 60);
  }
  // A distant peer is told whose states it waits for.
  std::uint64_t without = 0;
  const consensus::Peer& there = session.actors()[2].participant().peer();
  for (const consensus::PeerReport& report : there.reports()) {
    CHECK(report.late == 0);
    without += report.without;
  }
  CHECK(without == there.stats().replay.without);
  CHECK(without > 0);
}

}  // namespace
}  // namespace tandem::demos::late_member_test
