// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "scenes/scenario.h"

namespace tandem::demos {

/// The main() of a demo: reads the command line, runs, tells. Returns the exit code: 0; 1 for a
/// fault of the run or the system; 2 for a command line that is not understood.
int demo_main(int argc, char** argv, const Scenario& scenario);

}  // namespace tandem::demos
