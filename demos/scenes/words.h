// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tandem::demos {

/// With two significant digits, or as an integer: "0.07", "5.6", "123".
std::string two_digits(double value);
/// In the most readable unit, as "5.6 mm", "58 cm" or "1.6 m". @param metres  >= 0
std::string length_words(double metres);
/// "one cube", "two cubes", "13 cubes". @param many  the plural; empty = noun with an s
std::string count_words(std::size_t count, std::string_view one, std::string_view many = {});

}  // namespace tandem::demos
