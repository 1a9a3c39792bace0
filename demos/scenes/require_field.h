// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <stdexcept>
#include <string>

namespace tandem::demos {

/// @throws std::invalid_argument that names the options, the field, its value and the rule, unless
/// ok
inline void require_field(const char* options, bool ok, const char* field, double value,
                          const char* rule) {
  if (ok) return;
  throw std::invalid_argument(std::string(options) + ": " + field + " = " + std::to_string(value) +
                              " breaks: " + rule);
}

}  // namespace tandem::demos
