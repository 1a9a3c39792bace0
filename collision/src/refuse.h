// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// How this library refuses what it is given.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace tandem::collision {

/// @param what  field and value, in words
/// @throws std::invalid_argument "<what> breaks the rule: <rule>"
[[noreturn]] inline void refuse(const std::string& what, const std::string& rule) {
  throw std::invalid_argument(what + " breaks the rule: " + rule);
}

/// @throws std::invalid_argument "<field> = <value> breaks the rule: <rule>"
[[noreturn]] inline void refuse(const std::string& field, double value, const std::string& rule) {
  std::ostringstream text;
  text << field << " = " << value;
  refuse(text.str(), rule);
}

}  // namespace tandem::collision
