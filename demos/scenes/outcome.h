// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tandem::demos {

/// Named numbers: what somebody achieved. Truths are 0 or 1.
using Outcome = std::vector<std::pair<std::string, double>>;

/// A number over time, as a user's device measures it.
struct Series {
  std::string name;
  std::vector<double> times;  ///< s since the epoch
  std::vector<double> values;
};

}  // namespace tandem::demos
