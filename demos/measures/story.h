// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdio>
#include <string>

#include "measures/report.h"
#include "scenes/scenario.h"

namespace tandem::demos {

/// True if `file` is a terminal and NO_COLOR (no-color.org) is not set.
bool may_colour(std::FILE* file);

/// A summary for newcomers: how far people and copies were apart, what was achieved, and why a
/// second run lost.
/// @param beside  the same with another coupling; null = none
/// @param colour  with terminal escapes
std::string story(const Scenario& scenario, const Report& report, const Report* beside,
                  bool colour);

}  // namespace tandem::demos
