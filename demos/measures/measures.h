// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "measures/agreement.h"
#include "measures/json.h"
#include "measures/metrics.h"
#include "measures/smoothness.h"
#include "measures/stretch.h"
#include "runner/virtual_runner.h"
#include "session/options.h"

namespace tandem::demos {

/// Counts in equal bins from `low` on; values outside count in the first or last bin.
std::vector<std::uint64_t> histogram(const std::vector<double>& values, double low, double width,
                                     std::size_t bins);

struct Measures {
  static constexpr double kAgreed = 5e-3;  ///< m, bodies nearer than this agree

  Smoothness smooth;
  AfterBlows hits;
  Distribution link_ms;                                          ///< virtual links only
  std::vector<std::uint64_t> link_histogram, latency_histogram;  ///< 1 ms bins from 0
  Distribution contact_disagreement;
  double contact_disagreement_end = Distribution::kNone;
  double agree_s = Distribution::kNone;  ///< see time_to_agree
  HeldByOne held;
  Distribution limit_of_all_m;
  Stretch stretch;

  /// The same inputs at one peer, if run.
  std::optional<Smoothness> reference;
  Outcome reference_outcome;
  Stretch reference_stretch;
  Distribution residual_m;  ///< see high_pass_residual
};

/// @param reference  null: the inputs were not run again
Measures measure(const RunResult& run, const Metrics& metrics, const DemoOptions& options,
                 const RunResult* reference);

/// Writes fields of the open object.
void write_classes(JsonWriter& json, const Metrics& metrics);
void write_measures(JsonWriter& json, const Measures& measures);

}  // namespace tandem::demos
