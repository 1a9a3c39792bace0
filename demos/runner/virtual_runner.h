// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "runner/progress.h"
#include "scenes/scenario.h"
#include "session/options.h"
#include "session/track.h"

namespace tandem::demos {

/// What a runner hands over.
struct RunResult {
  std::vector<PeerRecord> peers;  ///< this process's own first
  double seconds = 0.0;           ///< s, session time that passed
  double wall_s = 0.0;            ///< s, that it took
  double cpu_s = 0.0;             ///< s, processor time of it; 0 = not measured
  /// s: how far session time here was from the others' at most, when it ended; < 0 = not known.
  double clock_error = -1.0;
};

/// All peers in this process, in virtual time over a virtual link. Events are ordered by time, then
/// ends of steps before beginnings, then peer: same options, same result, bit for bit.
/// @param replay  what the users do; null: what options.replay holds, else their script
/// @param progress  is told how far it is; null = nobody is
/// @throws std::invalid_argument where scenario or link refuse the options
RunResult run_virtual(const Scenario& scenario, const DemoOptions& options,
                      const std::vector<Input>* replay = nullptr, Progress* progress = nullptr);

/// The same inputs at one peer, where nothing is late: what a run is compared with.
RunResult run_reference(const Scenario& scenario, const DemoOptions& options,
                        const RunResult& original, Progress* progress = nullptr);

}  // namespace tandem::demos
