// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <vector>

#include "session/options.h"

namespace tandem::demos {

/// The options of a run as words that parse_options() reads back: all that a peer's behaviour
/// depends on, numbers with every bit. Without addresses, keys, waiting times and where results go:
/// a run over a network is "--listen 0 --peer-id N" here, and over UDP "--transport udp".
std::vector<std::string> run_arguments(const DemoOptions& options);

}  // namespace tandem::demos
