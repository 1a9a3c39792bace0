// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "measures/measures.h"
#include "measures/metrics.h"
#include "runner/virtual_runner.h"
#include "session/options.h"

namespace tandem::demos {

struct Report {
  std::string scenario;
  DemoOptions options;
  RunResult run;
  Metrics metrics;
  Measures measures;
  std::vector<std::string> body_names;
  std::string fault;  ///< the first fault of any peer; empty if the run was stable

  bool stable() const { return fault.empty(); }
};

/// Evaluates the run. @param reference  null: its inputs were not run at one peer
Report make_report(std::string scenario, const DemoOptions& options, RunResult run,
                   std::vector<std::string> body_names, const RunResult* reference = nullptr);

/// For people: aligned, in mm and degrees.
std::string report_table(const Report& report);
/// For programs: one JSON object; unknown values are null.
std::string report_json(const Report& report);

/// Writes divergence.csv (every sample), tracks.csv (every body at every peer), series.csv (users'
/// devices) and bodies.csv (a line per body) into `folder`, which is created if missing. @throws
/// std::runtime_error if a file cannot be written
void write_csv(const Report& report, const std::string& folder);

/// Writes the users' inputs, for --script. @throws std::runtime_error if the file cannot be written
void write_inputs(const Report& report, const std::string& path);

/// Standard output, or standard error if the JSON object goes there.
std::FILE* words_go_to(const DemoOptions& options);

/// Writes and prints what the options ask for. Returns the exit code: 0, or 1 for a run with a
/// fault. @param words  for people @throws std::runtime_error if a file cannot be written
int publish(const Report& report, const std::string& words);

}  // namespace tandem::demos
