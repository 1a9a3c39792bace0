// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <time.h>

#include <algorithm>
#include <vector>

#include "tandem/pbd/cpu_timer.h"

namespace tandem::bench {

inline double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}
/// s
inline double wall_seconds() { return seconds(CLOCK_MONOTONIC); }
/// s, CPU time of the calling thread.
inline double thread_seconds() { return pbd::thread_cpu_seconds(); }

/// The quantile q (0 to 1) of the values; 0 for an empty list.
inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const auto at = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  return values[at];
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace tandem::bench
