// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "runner/virtual_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <optional>

#include "runner/virtual_session.h"

namespace tandem::demos {

namespace {

using consensus::SessionTime;

std::string note(double seconds, double of) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.1f of %.1f s", seconds, of);
  return text;
}

}  // namespace

RunResult run_virtual(const Scenario& scenario, const DemoOptions& options,
                      const std::vector<Input>* replay, Progress* progress) {
  const std::clock_t cpu_start = std::clock();
  const auto wall_start = std::chrono::steady_clock::now();
  std::optional<std::vector<Input>> from_file;
  if (replay == nullptr) from_file = replayed_inputs(options);
  VirtualSession session(scenario, options, from_file ? &*from_file : replay);

  const SessionTime end = kVirtualStart + std::llround(options.seconds * 1e9);
  while (const auto now = session.act(end)) {
    if (progress == nullptr) continue;
    const double passed = static_cast<double>(*now - kVirtualStart) * 1e-9;
    progress->show(passed / options.seconds, note(passed, options.seconds));
  }
  if (progress != nullptr) progress->next_run();

  session.close_traces();
  RunResult result;
  for (Actor& actor : session.actors()) result.peers.push_back(actor.participant().record());
  result.seconds = options.seconds;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start;
  result.wall_s = wall.count();
  result.cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  return result;
}

RunResult run_reference(const Scenario& scenario, const DemoOptions& options,
                        const RunResult& original, Progress* progress) {
  DemoOptions alone = options;
  alone.peers = 1;
  alone.trace.clear();
  std::vector<Input> inputs;
  for (const PeerRecord& peer : original.peers) {
    inputs.insert(inputs.end(), peer.inputs.begin(), peer.inputs.end());
  }
  return run_virtual(scenario, alone, &inputs, progress);
}

}  // namespace tandem::demos
