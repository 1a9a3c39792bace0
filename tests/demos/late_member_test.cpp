// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One member whose states are old, true or false, beside some who are near each other. The others
// do to the bit what they do without it.
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "demos/runs.h"
#include "runner/virtual_session.h"
#include "scenes/scenario_list.h"
#include "support/catch.h"
#include "tandem/consensus/update.h"

namespace tandem::demos::late_member_test {
namespace {

using consensus::PeerId;
using consensus::SessionTime;
using consensus::StateUpdate;

constexpr PeerId kLate = 99;

/// What the late member says of the first peer's bodies.
struct Saying {
  double age = 0.0;        ///< s
  double other_age = age;  ///< s, of every other update
  double influence = 0.08;
  double aside = 0.0;          ///< m, by which it lies
  int every = 1;               ///< steps
  std::size_t bodies = 1'000;  ///< at most
  bool leads = false;
};

struct Company {
  std::vector<std::uint64_t> worlds;  ///< hashes of the honest peers' at the end
  std::vector<consensus::ReplayStats> replays;
  std::vector<std::uint64_t> late;  ///< what they report of the late member
  std::vector<std::uint64_t> without;
};

class LateMember {
 public:
  LateMember(VirtualSession& session, const Saying& saying)
      : session_(session), saying_(saying), line_(session.network().transport(kLate)) {}

  void look(SessionTime now) {
    Actor& truth = session_.actors()[0];
    if (truth.reached() == last_) return;
    last_ = truth.reached();
    const Scene& scene = truth.participant().scene();
    Shot& shot = past_.emplace_back(Shot{last_, {}});
    for (const SceneBody& body : scene.bodies) shot.states.push_back(scene.world->state(body.body));
    if (past_.size() > 80) past_.pop_front();
    // Nobody is a newcomer any more.
    if (now < kVirtualStart + 2'000'000'000 || ++steps_ % saying_.every != 0) return;
    const double age = ++turns_ % 2 == 0 ? saying_.age : saying_.other_age;
    const Shot& then = *std::ranges::min_element(past_, {}, [&](const Shot& s) {
      return std::abs(1e-9 * static_cast<double>(now - s.time) - age);
    });
    std::vector<StateUpdate> says;
    for (std::size_t i = 0; i < std::min(saying_.bodies, then.states.size()); ++i) {
      StateUpdate update{.id = scene.bodies[i].id,
                         .pose = then.states[i].pose,
                         .twist = then.states[i].twist,
                         .influence = static_cast<float>(saying_.influence),
                         .stamp = then.time,
                         .flags = {.leads = saying_.leads}};
      update.pose.position.x() += saying_.aside;
      says.push_back(update);
    }
    std::vector<std::byte> bytes;
    encode(says, bytes);
    for (std::size_t i = 0; i < session_.actors().size(); ++i) {
      line_.post(i + 1, bytes, consensus::Delivery::Newest);
    }
  }

 private:
  struct Shot {
    SessionTime time = 0;
    std::vector<pbd::BodyState> states;
  };
  VirtualSession& session_;
  Saying saying_;
  consensus::Transport& line_;
  std::deque<Shot> past_;
  SessionTime last_ = 0;
  int steps_ = 0;
  int turns_ = 0;
};

Company run(const std::string& scene, int honest, int profile, const Saying* saying) {
  const auto scenario = make_scenario(scene);
  DemoOptions options = quiet(profile, 4.0);
  options.peers = honest;
  VirtualSession session(*scenario, options, nullptr);
  std::optional<LateMember> late;
  if (saying != nullptr) late.emplace(session, *saying);
  while (const auto now = session.act(kVirtualStart + 4'000'000'000)) {
    if (late) late->look(*now);
  }
  Company company;
  for (Actor& actor : session.actors()) {
    company.worlds.push_back(actor.participant().record().hash);
    const consensus::Peer& peer = actor.participant().peer();
    company.replays.push_back(peer.stats().replay);
    const auto found = std::ranges::find(peer.reports(), kLate, &consensus::PeerReport::peer);
    if (found == peer.reports().end()) continue;
    company.late.push_back(found->late);
    company.without.push_back(found->without);
  }
  return company;
}

TEST_CASE("late member: nobody else moves otherwise, or pays for it", "[demos]") {
  const auto [honest, profile] = GENERATE(table<int, int>({{2, 1}, {2, 5}, {3, 3}, {6, 3}}));
  const Company alone = run("cubes", honest, profile, nullptr);
  for (const Saying& saying :
       {Saying{.age = 0.84}, Saying{.age = 0.84, .influence = 1e-30, .bodies = 1},
        Saying{.age = 0.4, .influence = 1.0, .leads = true}, Saying{.age = 0.5, .aside = 0.3},
        Saying{.age = 0.3, .other_age = 0.8, .every = 20}}) {
    CAPTURE(honest, profile, saying.age, saying.influence, saying.aside, saying.every);
    const Company beside = run("cubes", honest, profile, &saying);
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

TEST_CASE("late member: who is far follows, and the near ones have what they have without it",
          "[demos]") {
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
  // Who is far is told whose states it waits for.
  std::uint64_t without = 0;
  const consensus::Peer& there = session.actors()[2].participant().peer();
  for (const consensus::PeerReport& report : there.reports()) {
    CHECK(report.late == 0);
    without += report.without;
  }
  CHECK(without == there.stats().replay.without);
  CHECK(without > 60);
}

}  // namespace
}  // namespace tandem::demos::late_member_test
