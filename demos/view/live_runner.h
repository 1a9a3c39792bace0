// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

#include "runner/virtual_runner.h"
#include "scenes/scenario.h"
#include "session/options.h"

namespace tandem::demos::view {

/// Whether this build has the page and its server; where it has not, nothing below may be called.
bool has_view();

/// What it would need and where to read of it, for people.
std::string missing();

/// A run in virtual time at the pace of the clock, shown on a page and played with from there,
/// until it has lasted as long as it should or is stopped.
/// @throws std::invalid_argument where scenario, link or address refuse the options,
///   std::runtime_error where the page cannot be served
RunResult run_live(const Scenario& scenario, const DemoOptions& options);

}  // namespace tandem::demos::view
