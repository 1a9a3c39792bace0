// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace tandem::demos {

/// All that the last bits of a result may depend on besides the input, in one line: version,
/// compiler and flags, C library, and the instructions by which it selects functions.
std::string build_facts();

}  // namespace tandem::demos
