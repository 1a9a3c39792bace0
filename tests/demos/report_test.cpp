// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/report.h"

#include <string>

#include "measures/json.h"
#include "support/catch.h"

namespace tandem::demos::report_test {
namespace {

TEST_CASE("report: every promised field is in the object, unknown ones as null", "[demos][unit]") {
  RunResult run;
  PeerRecord a;
  a.id = 1;
  a.step_hz = 60.0;
  a.tracks.resize(1);
  PeerRecord b = a;
  b.id = 2;
  b.local = false;
  run.peers = {a, b};
  run.seconds = 1.0;
  run.wall_s = 0.5;
  const Report report = make_report("empty", {}, run, {"body"});
  const std::string json = report_json(report);
  for (const char* name : {"scenario",
                           "solver",
                           "predictor",
                           "profile",
                           "peers",
                           "seconds",
                           "seed",
                           "step_hz",
                           "update_hz",
                           "influence",
                           "divergence_m",
                           "divergence_contested_m",
                           "divergence_moving_m",
                           "divergence_resting_m",
                           "divergence_deg",
                           "prediction_error_m",
                           "effective_latency_ms",
                           "overhead_us_per_object",
                           "parse",
                           "process",
                           "aggregate",
                           "bytes_per_second",
                           "step_ms",
                           "realtime_factor",
                           "penetration_m",
                           "energy_J",
                           "displacement",
                           "velocity_agreement",
                           "potential",
                           "divergence_calm_m",
                           "divergence_shared_m",
                           "classes",
                           "touching",
                           "link_ms",
                           "effective_latency_histogram",
                           "smoothness",
                           "spectral_arc_length",
                           "pops_per_minute",
                           "contact_disagreement",
                           "time_to_agree_s",
                           "held_limit_m",
                           "stretch_m",
                           "bodies_placed",
                           "limit_of_all_m",
                           "reference",
                           "hash",
                           "stable",
                           "p50",
                           "p75",
                           "p95",
                           "p99",
                           "max"}) {
    CHECK_THAT(json, Catch::Contains(json_string(name) + ": "));
  }
  CHECK_THAT(json, Catch::Contains("\"p50\": null"));
  CHECK_THAT(json, Catch::Contains("\"realtime_factor\": 2"));
  CHECK_THAT(json, !Catch::Contains("nan"));
  CHECK_THAT(json, !Catch::Contains("inf\""));
}

TEST_CASE("report: the first fault of any peer makes the run unstable", "[demos][unit]") {
  RunResult run;
  run.peers.resize(2);
  run.peers[1].fault = "peer 2, 1.00 s: cube is too fast";
  const Report report = make_report("empty", {}, run, {});
  CHECK_FALSE(report.stable());
  CHECK_THAT(report_json(report), Catch::Contains("\"stable\": false"));
  CHECK_THAT(report_table(report), Catch::Contains("cube is too fast"));
}

}  // namespace
}  // namespace tandem::demos::report_test
