// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdio>
#include <string>

#include "measures/report.h"
#include "scenes/scenario.h"

namespace tandem::demos {

/// Whether what is written there may be coloured: it is a terminal, and NO_COLOR (no-color.org) is
/// not set.
bool may_colour(std::FILE* file);

/// What happened, for who sees it for the first time: how far people and copies were apart, what
/// was achieved, and, beside another run, both and why that one lost.
/// @param beside  the same with another coupling; null = nothing
/// @param colour  with the escapes of a terminal
std::string story(const Scenario& scenario, const Report& report, const Report* beside,
                  bool colour);

}  // namespace tandem::demos
