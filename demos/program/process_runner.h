// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "runner/virtual_runner.h"
#include "scenes/scenario.h"
#include "session/options.h"

namespace tandem::demos {

/// One peer in this process, in wall time over TCP. The users' script begins when the first
/// processes have found each other (see Rendezvous): peer 1 is user A, peer 2 user B, others only
/// watch. Ends `seconds` later, or in order at SIGINT or SIGTERM.
///
/// Other peers' states are known as they are sent, at their stamps.
/// @throws std::invalid_argument if scenario or transport refuse the options
/// @throws std::system_error if it cannot listen
/// @throws std::runtime_error if nobody came in time (--wait)
RunResult run_process(const Scenario& scenario, const DemoOptions& options);

}  // namespace tandem::demos
