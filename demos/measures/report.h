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

/// A run and what it comes to, as it is told.
struct Report {
  std::string scenario;
  DemoOptions options;
  RunResult run;
  Metrics metrics;
  Measures measures;
  std::vector<std::string> body_names;
  std::string fault;  ///< the first fault of any peer; empty where the run was stable

  bool stable() const { return fault.empty(); }
};

/// Evaluates the run. @param reference  null: nobody ran its inputs at one peer
Report make_report(std::string scenario, const DemoOptions& options, RunResult run,
                   std::vector<std::string> body_names, const RunResult* reference = nullptr);

/// For people: aligned, in mm and degrees.
std::string report_table(const Report& report);
/// For programs: one JSON object; what is not known is null.
std::string report_json(const Report& report);

/// Writes divergence.csv (every sample), tracks.csv (where every body was at every peer),
/// series.csv (what users' devices measured) and bodies.csv (a line for each body) into `folder`,
/// which is made where it is missing. @throws std::runtime_error saying what cannot be written
void write_csv(const Report& report, const std::string& folder);

/// Writes what the users did, for --script. @throws std::runtime_error saying what cannot be
/// written
void write_inputs(const Report& report, const std::string& path);

/// Standard output is the object's alone where it is asked for there.
std::FILE* words_go_to(const DemoOptions& options);

/// Writes and prints what the options ask for. Returns the exit code: 0, or 1 for a run with a
/// fault. @param words  for people @throws std::runtime_error saying what cannot be written
int publish(const Report& report, const std::string& words);

}  // namespace tandem::demos
