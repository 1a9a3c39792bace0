// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdio>

namespace tandem::demos {

/// Whether somebody reads along who understands cursor movements and colours. A console of Windows
/// is told to, and to take UTF-8.
bool is_terminal(std::FILE* file);

/// Width of the terminal that shows standard error; 80 where none is known.
std::size_t terminal_columns();

}  // namespace tandem::demos
