// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

namespace tandem::extreme_bench {

/// Prints, as CSV, one peer's CPU time (us) per body and step in a session of 2 to 16: of the
/// solver, and of packets, prediction and fusion. Session sizes take turns; each value is from the
/// least disturbed tenth of rounds.
void print_costs();

}  // namespace tandem::extreme_bench
