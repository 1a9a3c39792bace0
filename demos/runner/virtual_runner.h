// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "runner/progress.h"
#include "scenes/scenario.h"
#include "session/options.h"
#include "session/track.h"

namespace tandem::demos {

struct RunResult {
  std::vector<PeerRecord> peers;  ///< this process's own first
  double seconds = 0.0;           ///< s, session time
  double wall_s = 0.0;            ///< s, wall time
  double cpu_s = 0.0;             ///< s, processor time; 0 = not measured
  /// s: bound at the end on the error of session time; < 0 = not known.
  double clock_error = -1.0;
};

/// All peers in this process, in virtual time over a virtual link. Events are ordered by time, then
/// ends of steps before beginnings, then peer: same options, same result, bit for bit.
/// @param replay  the users' inputs; null: those of options.replay, else their script
/// @param progress  null = not reported
/// @throws std::invalid_argument if scenario or link refuse the options
RunResult run_virtual(const Scenario& scenario, const DemoOptions& options,
                      const std::vector<Input>* replay = nullptr, Progress* progress = nullptr);

/// The same inputs at one peer, without latency: the reference for a run.
RunResult run_reference(const Scenario& scenario, const DemoOptions& options,
                        const RunResult& original, Progress* progress = nullptr);

}  // namespace tandem::demos
