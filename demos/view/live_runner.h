// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

#include "runner/virtual_runner.h"
#include "scenes/scenario.h"
#include "session/options.h"

namespace tandem::demos::view {

/// True if this build has the page and its server; otherwise nothing below may be called.
bool has_view();

/// The missing dependency and its documentation, for people.
std::string missing();

/// A run in virtual time at the pace of the clock, shown on a page with controls, until its end or
/// until it is stopped.
/// @throws std::invalid_argument if scenario, link or address refuse the options,
///   std::runtime_error if the page cannot be served
RunResult run_live(const Scenario& scenario, const DemoOptions& options);

}  // namespace tandem::demos::view
