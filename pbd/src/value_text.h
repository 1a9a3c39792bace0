// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace tandem::pbd::detail {

/// A number as an error tells it. Small ones are not rounded to 0, large ones have no hundreds of
/// digits: callers in C have room for 255 characters.
inline std::string value_text(double value) {
  const double size = std::abs(value);
  if (value == 0.0 || (size >= 1e-3 && size < 1e9)) return std::to_string(value);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

}  // namespace tandem::pbd::detail
