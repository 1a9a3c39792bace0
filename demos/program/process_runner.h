// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "runner/virtual_runner.h"
#include "scenes/scenario.h"
#include "session/options.h"

namespace tandem::demos {

/// One peer in this process, in wall time over TCP. The world runs from the start; the users'
/// script begins when the first processes have found each other (see Rendezvous): peer 1 is user A,
/// peer 2 user B, others only watch. Ends `seconds` after the script's beginning, or at SIGINT or
/// SIGTERM; both leave the session in order.
///
/// Only the own world is known here; other peers' states are those they send, at their stamps.
/// @throws std::invalid_argument if scenario or transport refuse the options
/// @throws std::system_error if it cannot listen
/// @throws std::runtime_error if nobody came in time (--wait)
RunResult run_process(const Scenario& scenario, const DemoOptions& options);

}  // namespace tandem::demos
