// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

namespace tandem::extreme_bench {

/// What one peer of 2 to 16 spends on a body and a step, as CSV: in the solver, and in its share of
/// the session (packets, prediction, fusion), CPU time in us, the least disturbed tenth of
/// rounds in which all numbers of peers take turns.
void print_costs();

}  // namespace tandem::extreme_bench
