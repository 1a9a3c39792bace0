// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "common/virtual_runner.h"

#include "common/metrics.h"
#include "common/report.h"
#include "scenes/cubes.h"
#include "support/catch.h"

namespace tandem::demos {
namespace {

Report run(const DemoOptions& options) {
  const CubesScenario scenario;
  std::vector<std::string> names;
  for (const SceneBody& body : scenario.build({}).bodies) names.push_back(body.name);
  return make_report("cubes", options, run_virtual(scenario, options), names);
}

DemoOptions quiet(double seconds, int profile) {
  DemoOptions options;
  options.quiet = true;
  options.seconds = seconds;
  options.profile = profile;
  return options;
}

TEST_CASE("virtual run: same options, same bits; another seed, others", "[demos][golden]") {
  DemoOptions options = quiet(2.0, 4);
  options.uneven = true;
  options.loss = 0.05;
  const Report first = run(options);
  const Report second = run(options);
  CHECK(first.metrics.hash == second.metrics.hash);
  REQUIRE(first.metrics.samples.size() == second.metrics.samples.size());
  CHECK(first.metrics.divergence_m.max == second.metrics.divergence_m.max);
  options.seed = 2;
  CHECK(run(options).metrics.hash != first.metrics.hash);
}

TEST_CASE("virtual run: latency is the link's plus half a step, updates are at their rate",
          "[demos][analytic]") {
  DemoOptions options = quiet(2.0, 3);
  const Report report = run(options);
  // An update waits for the next beginning of a step: 0 to 1/60 s, the same for all updates of one
  // peer but for the jitter of 2.5 ms.
  CHECK(report.metrics.latency_ms.mean > 28.5 - 2.5);
  CHECK(report.metrics.latency_ms.mean < 28.5 + 2.5 + 1000.0 / 60.0);
  // 21 bodies of 93 bytes, 60 times each second, and some springs and headers.
  CHECK(report.metrics.bytes_per_second > 21 * 93 * 55);
  CHECK(report.metrics.bytes_per_second < 21 * 93 * 60 * 1.2);
}

TEST_CASE("virtual run: one peer alone does the whole script", "[demos][unit]") {
  DemoOptions options = quiet(16.0, 1);
  options.peers = 1;
  const Report report = run(options);
  CHECK(report.fault.empty());
  const std::vector<TrackSample>& plate = report.run.peers[0].tracks[0].samples();
  double highest = 0.0;
  int most_users = 0;
  for (const TrackSample& sample : plate) {
    highest = std::max(highest, sample.position.z());
    most_users = std::max(most_users, sample.users);
  }
  CHECK(highest > 0.2);
  CHECK(most_users == 2);
  CHECK(plate.back().position.z() == Approx(0.02).margin(2e-3));
  CHECK(plate.back().position.y() > 0.25);
}

// Bounds of the scene "stacked cubes": a whole session each.
TEST_CASE("cubes: two peers agree on a dedicated link", "[demos][soak]") {
  const Report report = run(quiet(20.0, 1));
  CHECK(report.fault == "");
  CHECK(report.metrics.resting_m.p50 <= 0.5e-3);
  CHECK(report.metrics.moving_m.p50 <= 5e-3);
  CHECK(report.metrics.contested_m.count > 100);
}

TEST_CASE("cubes: two peers agree across an ocean, and do not without agreement",
          "[demos][soak]") {
  const Report report = run(quiet(20.0, 5));
  CHECK(report.fault == "");
  CHECK(report.metrics.resting_m.p50 <= 0.5e-3);
  CHECK(report.metrics.moving_m.p50 <= 25e-3);

  DemoOptions without = quiet(20.0, 5);
  without.influence = 0.0;
  const Report apart = run(without);
  CHECK(apart.fault == "");
  CHECK(apart.metrics.divergence_m.p50 >= 5.0 * report.metrics.divergence_m.p50);
}

}  // namespace
}  // namespace tandem::demos
