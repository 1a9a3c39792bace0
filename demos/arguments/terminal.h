// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdio>

namespace tandem::demos {

/// True for a terminal with cursor movements and colours. Switches a Windows console to both and to
/// UTF-8.
bool is_terminal(std::FILE* file);

/// Width of the terminal on standard error; 80 if unknown.
std::size_t terminal_columns();

}  // namespace tandem::demos
