// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "core.h"

namespace tandem::python {

/// A copy of a step's report; the engine's is a reference into its solver.
struct Report {
  Report(const pbd::StepReport& step, double at) : report(step), time(at) {}
  pbd::StepReport report;
  double time = 0.0;  ///< s, of the world
};

void bind_report(py::module_& m);
/// @throws std::invalid_argument naming field, value and rule
void require_steps(double dt, int steps);

}  // namespace tandem::python
