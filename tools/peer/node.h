// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "peer/config.h"
#include "peer/log.h"
#include "scenes/scenario.h"

namespace tandem::demos {

/// Takes part in a session until SIGINT or SIGTERM, then leaves it in order. Nothing is recorded.
/// @throws std::exception with the reason if it cannot start
void run_node(const Scenario& scenario, const PeerConfig& config, Log& log);

}  // namespace tandem::demos
