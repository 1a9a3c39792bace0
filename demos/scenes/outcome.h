// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tandem::demos {

/// Named results. Booleans are 0 or 1.
using Outcome = std::vector<std::pair<std::string, double>>;

/// 0 if no number has that name.
inline double value_of(const Outcome& outcome, std::string_view name) {
  for (const auto& [known, value] : outcome) {
    if (known == name) return value;
  }
  return 0.0;
}

/// An outcome in words.
struct Achievement {
  std::string text;    ///< the users' act, as "carried one piano through a maze"
  std::string name;    ///< name of the figure, as "piano arrived"
  std::string figure;  ///< with its unit, as "after 16.5 s"
  bool done = true;    ///< the users reached their goal
};

/// A number over time, measured by a user's device.
struct Series {
  std::string name;
  std::vector<double> times;  ///< s since the epoch
  std::vector<double> values;
};

}  // namespace tandem::demos
