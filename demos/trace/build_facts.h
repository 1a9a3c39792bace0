// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>

namespace tandem::demos {

/// What the last bits of a result may depend on besides the input, in one line: version, compiler
/// and its flags, C library and instructions of this machine that it chooses functions by.
std::string build_facts();

}  // namespace tandem::demos
