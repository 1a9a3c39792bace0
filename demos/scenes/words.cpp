// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/words.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace tandem::demos {

std::string two_digits(double value) {
  std::array<char, 64> text{};
  // From 9.95 on two digits leave no fraction.
  std::snprintf(text.data(), text.size(), std::abs(value) < 9.95 ? "%.2g" : "%.0f", value);
  return text.data();
}

std::string length_words(double metres) {
  if (metres < 1e-5) return "less than 0.01 mm";
  if (metres < 0.0995) return two_digits(1e3 * metres) + " mm";
  if (metres < 0.995) return two_digits(1e2 * metres) + " cm";
  return two_digits(metres) + " m";
}

std::string count_words(std::size_t count, std::string_view one, std::string_view many) {
  constexpr std::array<std::string_view, 11> kNames{
      "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"};
  std::string text = count < kNames.size() ? std::string(kNames[count]) : std::to_string(count);
  text += ' ';
  if (count == 1) return text += one;
  return many.empty() ? (text += one) += 's' : text += many;
}

}  // namespace tandem::demos
