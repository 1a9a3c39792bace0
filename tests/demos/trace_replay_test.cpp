// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a peer does is done again from its trace alone.
#include <algorithm>
#include <memory>
#include <vector>

#include "runs.h"
#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/pile.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "session/actor.h"
#include "support/catch.h"
#include "tandem/consensus/virtual_network.h"
#include "trace/peer_trace.h"
#include "trace_support.h"

namespace tandem::demos::trace_replay_test {
namespace {

/// Runs it and checks that each peer's replay is what the peer did.
void check_replays(const Scenario& scenario, const DemoOptions& options) {
  const TracedRun run = traced_run(scenario, options);
  for (std::size_t i = 0; i < run.traces.size(); ++i) {
    const PeerRecord& peer = run.result.peers[i];
    INFO(scenario.name() << ", " << to_string(options.scheme) << ", peer " << peer.id);
    const Replay again = replay(scenario, run.traces[i]);
    if (again.departure) UNSCOPED_INFO(to_text(*again.departure, ""));
    CHECK_FALSE(again.departure);
    CHECK(again.steps == peer.step_s.size());
    CHECK(again.hash == peer.hash);
  }
}

TEST_CASE("trace: a replay of every demo is bit-exact, in one pass and in two steps",
          "[demos][golden]") {
  PileOptions small_pile;
  small_pile.rows = 5;
  std::vector<std::unique_ptr<Scenario>> scenarios;
  scenarios.push_back(std::make_unique<CubesScenario>());
  scenarios.push_back(std::make_unique<CliffScenario>());
  scenarios.push_back(std::make_unique<RoomScenario>());
  scenarios.push_back(std::make_unique<PianoScenario>());
  scenarios.push_back(std::make_unique<TennisScenario>());
  scenarios.push_back(std::make_unique<PileScenario>(small_pile));
  for (const auto& scenario : scenarios) {
    for (const Scheme scheme : {Scheme::OnePass, Scheme::TwoStepPaper}) {
      // The tennis players serve, and the piano is grasped, within the first two seconds.
      DemoOptions options = quiet(3, scenario->name() == "cliff" ? 0.7 : 2.5);
      options.scheme = scheme;
      check_replays(*scenario, options);
    }
  }
}

TEST_CASE("trace: a replay is bit-exact for all answers of a transport", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  DemoOptions options = quiet(4, 3.0);
  options.peers = 3;
  options.rates = {60.0, 72.0};
  options.loss = 0.1;
  options.duplicate = 0.1;
  options.reorder = 0.1;
  options.max_state_bytes = 502;
  check_replays(scenario, options);
  options.compact = true;
  options.budget = 40.0;
  options.bandwidth = 30e3;
  options.tolerance = 1e-3;
  check_replays(scenario, options);
  options.timeline = Timeline::None;
  options.clock_spread = 0.25;
  check_replays(scenario, options);
  options = quiet(2, 2.0);
  options.mode = consensus::InputMode::Hard;
  options.ablation.leave_out(Part::Velocities);
  check_replays(scenario, options);
}

TEST_CASE("trace: a replay of a peer on Bullet is bit-exact", "[demos][golden]") {
  if (!has_bullet()) {
    WARN("skipped: built without Bullet (TANDEM_BULLET_PEER)");
    return;
  }
  DemoOptions options = quiet(3, 2.5);
  options.engines = {Engine::Tandem, Engine::Bullet};
  options.rates = {60.0, 72.0};
  check_replays(CubesScenario(), options);
}

TEST_CASE("trace: a replay follows a change of rules", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  const Folder folder;
  DemoOptions options = quiet(2, 3.0);
  options.trace = folder.file("trace");
  consensus::VirtualNetwork network(options.link_options(), 1, kVirtualStart);
  network.transport(1);
  network.transport(2);
  std::vector<std::unique_ptr<PeerTrace>> traces;
  std::vector<Actor> actors;
  for (std::size_t i = 0; i < 2; ++i) {
    traces.push_back(open_trace(scenario, options, i + 1, i, network.transport(i + 1), true));
    actors.emplace_back(scenario, options, i, traces[i]->transport());
    actors[i].participant().watch_steps_with(traces[i].get());
    actors[i].participant().add_user(i, user_options(options, i, kVirtualStart));
    // Forgets what users do, but not before it is told.
    if (i == 1) actors[i].participant().record_nothing();
  }
  DemoOptions others = options;
  others.scheme = Scheme::TwoStep;
  others.influence = 0.2;
  bool changed = false;
  while (true) {
    Actor& next = actors[next_actor(actors)];
    const consensus::SessionTime now = std::get<0>(next.next());
    if (now > kVirtualStart + 3'000'000'000) break;
    if (!changed && now > kVirtualStart + 2'000'000'000) {
      changed = true;
      for (Actor& actor : actors) actor.participant().change_rules(others);
    }
    network.advance_to(now);
    next.act();
  }
  for (const auto& trace : traces) trace->close();
  for (std::size_t i = 0; i < 2; ++i) {
    const Bytes trace = read_bytes(options.trace + '.' + std::to_string(i + 1));
    const Replay again = replay(scenario, trace);
    if (again.departure) UNSCOPED_INFO(to_text(*again.departure, ""));
    CHECK_FALSE(again.departure);
    CHECK(again.hash == actors[i].participant().scene().world->hash());
    const std::vector<TraceRecord> records = records_of(trace);
    const auto count = [&records](TraceKind kind) {
      return std::count_if(records.begin(), records.end(),
                           [kind](const auto& each) { return each.kind == kind; });
    };
    CHECK(count(TraceKind::Rules) == 1);
    CHECK(count(TraceKind::Inputs) > 0);
  }
}

TEST_CASE("trace: tracing changes nothing", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  const DemoOptions options = quiet(3, 2.0);
  const RunResult plain = run_virtual(scenario, options);
  const TracedRun traced = traced_run(scenario, options);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(plain.peers[i].hash == traced.result.peers[i].hash);
    CHECK(plain.peers[i].bytes_sent == traced.result.peers[i].bytes_sent);
  }
}

}  // namespace
}  // namespace tandem::demos::trace_replay_test
