// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/virtual_runner.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>
#include <tuple>

#include "common/actor.h"
#include "common/progress.h"
#include "scenes/random.h"
#include "tandem/consensus/virtual_link.h"
#include "trace/peer_trace.h"

namespace tandem::demos {

namespace {

using consensus::SessionTime;

std::string session_note(double seconds) {
  char note[32];
  std::snprintf(note, sizeof(note), "%.1f s", seconds);
  return note;
}

}  // namespace

RunResult run_virtual(const Scenario& scenario, const DemoOptions& options,
                      const std::vector<Input>* replay,
                      std::span<consensus::PeerObserver* const> observers) {
  const std::clock_t cpu_start = std::clock();
  const auto wall_start = std::chrono::steady_clock::now();
  consensus::VirtualNetwork network(options.link_options(), derived_seed(options.seed, 5000),
                                    kVirtualStart);
  const auto count = static_cast<std::size_t>(options.peers);
  // All join before the first of them looks around.
  for (std::size_t i = 0; i < count; ++i) {
    network.transport(i + 1);
    network.set_clock(i + 1, clock_ahead(options, i));
  }
  // They outlive the actors, who use them.
  std::vector<std::unique_ptr<PeerTrace>> traces(count);
  std::vector<Actor> actors;
  actors.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    consensus::Transport& transport = network.transport(i + 1);
    traces[i] = open_trace(scenario, options, i + 1, i, transport, true);
    actors.emplace_back(scenario, options, i, traces[i] ? traces[i]->transport() : transport);
    if (traces[i]) actors.back().participant().watch_steps_with(traces[i].get());
    if (i < observers.size()) actors.back().participant().watch_with(observers[i]);
  }
  std::optional<std::vector<Input>> from_file;
  if (replay == nullptr) from_file = replayed_inputs(options);
  if (from_file) replay = &*from_file;
  for (std::size_t user = 0; user < scenario.user_count() && !options.no_script; ++user) {
    actors[seat_of(options, user)].participant().add_user(
        user, user_options(options, user, kVirtualStart), replay);
  }

  Progress progress(options.quiet);
  const SessionTime end = kVirtualStart + std::llround(options.seconds * 1e9);
  while (true) {
    const std::size_t first = next_actor(actors);
    const SessionTime now = std::get<0>(actors[first].next());
    if (now > end) break;
    network.advance_to(now);
    actors[first].act();
    const double passed = static_cast<double>(now - kVirtualStart) * 1e-9;
    progress.show(passed / options.seconds, session_note(passed));
  }

  for (const auto& trace : traces) close_trace(trace.get());
  RunResult result;
  for (Actor& actor : actors) result.peers.push_back(actor.participant().record());
  result.seconds = options.seconds;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start;
  result.wall_s = wall.count();
  result.cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  return result;
}

RunResult run_reference(const Scenario& scenario, const DemoOptions& options,
                        const RunResult& original) {
  DemoOptions alone = options;
  alone.peers = 1;
  alone.trace.clear();
  std::vector<Input> inputs;
  for (const PeerRecord& peer : original.peers) {
    inputs.insert(inputs.end(), peer.inputs.begin(), peer.inputs.end());
  }
  return run_virtual(scenario, alone, &inputs);
}

}  // namespace tandem::demos
