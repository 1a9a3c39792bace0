// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <vector>

#include "session/options.h"

namespace tandem::demos {

/// The options of a run as arguments for parse_options(): everything that a peer's behaviour
/// depends on, numbers with every bit. Addresses, keys, waiting times and output files are omitted:
/// a run over a network becomes "--listen 0 --peer-id N", with "--transport udp" over UDP.
std::vector<std::string> run_arguments(const DemoOptions& options);

}  // namespace tandem::demos
