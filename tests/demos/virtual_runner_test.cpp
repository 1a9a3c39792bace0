// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "runner/virtual_runner.h"

#include <filesystem>

#include "measures/metrics.h"
#include "measures/report.h"
#include "runs.h"
#include "scenes/cubes.h"
#include "support/catch.h"

namespace tandem::demos::virtual_runner_test {
namespace {

/// Half as many stacks on half a plate, to be quick.
const CubesOptions kSmall{.stacks = 2, .height = 3, .plate = pbd::Vec3(0.8, 0.8, 0.04)};

Report run(const DemoOptions& options, const CubesOptions& cubes = kSmall) {
  const CubesScenario scenario(cubes);
  std::vector<std::string> names;
  for (const SceneBody& body : scenario.build({}).bodies) names.push_back(body.name);
  return make_report("cubes", options, run_virtual(scenario, options), names);
}

TEST_CASE("virtual run: same options, same bits; another seed, others", "[demos][golden]") {
  DemoOptions options = quiet(4, 2.0);
  options.rates = {60.0, 72.0};
  options.loss = 0.05;
  const Report first = run(options);
  const Report second = run(options);
  CHECK(first.metrics.hash == second.metrics.hash);
  REQUIRE(first.metrics.samples.size() == second.metrics.samples.size());
  CHECK(first.metrics.divergence_m.max == second.metrics.divergence_m.max);
  options.seed = 2;
  CHECK(run(options).metrics.hash != first.metrics.hash);
}

TEST_CASE("virtual run: without a coupling is with no influence, bit for bit", "[demos][golden]") {
  DemoOptions none = quiet(3, 4.0);
  none.scheme = Scheme::None;
  DemoOptions mute = quiet(3, 4.0);
  mute.influence = 0.0;
  const RunResult a = run_virtual(CubesScenario(), none);
  const RunResult b = run_virtual(CubesScenario(), mute);
  for (std::size_t i = 0; i < 2; ++i) CHECK(a.peers[i].hash == b.peers[i].hash);
  CHECK(a.peers[0].bodies_aggregated == 0);
}

TEST_CASE("virtual run: clocks do not matter if states are dated on receipt", "[demos][golden]") {
  DemoOptions options = quiet(5, 6.0);
  options.timeline = Timeline::None;
  const Report together = run(options);
  options.clock_spread = 86400.0;
  const Report apart = run(options);
  CHECK(apart.metrics.hash == together.metrics.hash);
  CHECK(apart.metrics.divergence_m.max == together.metrics.divergence_m.max);
  CHECK(run_virtual(CubesScenario(kSmall), options).peers[0].bodies_aggregated > 0);
  // Read as they are such stamps are refused, until it has shown for a second that they are of
  // another clock.
  options.timeline = Timeline::Session;
  CHECK(run_virtual(CubesScenario(kSmall), options).peers[0].bodies_aggregated > 0);
}

TEST_CASE("virtual run: a reference is the same inputs at one peer", "[demos][golden]") {
  const CubesScenario scenario(kSmall);
  DemoOptions options = quiet(5, 3.0);
  const RunResult shared = run_virtual(scenario, options);
  const RunResult reference = run_reference(scenario, options, shared);
  REQUIRE(reference.peers.size() == 1);
  CHECK(reference.peers[0].first_exchange == INT64_MAX);
  CHECK(reference.peers[0].inputs.size() ==
        shared.peers[0].inputs.size() + shared.peers[1].inputs.size());
  // For a run at one peer the reference is the same, bit for bit.
  options.peers = 1;
  const RunResult alone = run_virtual(scenario, options);
  CHECK(run_reference(scenario, options, alone).peers[0].hash == alone.peers[0].hash);
}

TEST_CASE("virtual run: recorded inputs, repeated, give the same bits", "[demos][golden]") {
  const std::string path =
      (std::filesystem::temp_directory_path() / "tandem-virtual-runner-inputs").string();
  DemoOptions options = quiet(3, 4.0);
  const Report first = run(options);
  write_inputs(first, path);
  options.replay = path;
  const Report again = run(options);
  std::filesystem::remove(path);
  REQUIRE_FALSE(first.run.peers[0].inputs.empty());
  CHECK(again.metrics.hash == first.metrics.hash);
}

TEST_CASE("virtual run: latency is the link's plus half a step, updates are at their rate",
          "[demos][analytic]") {
  DemoOptions options = quiet(3, 2.0);
  const Report report = run(options);
  // An update waits for the next beginning of a step: 0 to 1/60 s, the same for all updates of one
  // peer but for the jitter of 2.5 ms.
  CHECK(report.metrics.latency_ms.mean > 28.5 - 2.5);
  CHECK(report.metrics.latency_ms.mean < 28.5 + 2.5 + 1000.0 / 60.0);
  // 10 bodies of 93 bytes, 60 times each second, and some springs and headers.
  CHECK(report.metrics.bytes_per_second > 10 * 93 * 55);
  CHECK(report.metrics.bytes_per_second < 10 * 93 * 60 * 1.3);
}

TEST_CASE("virtual run: one peer alone does the whole script", "[demos][unit]") {
  DemoOptions options = quiet(1, 16.0);
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

// Bounds of the scene "stacked cubes". The plate is lifted from 8 to 15 s.

TEST_CASE("cubes: three uneven peers agree on a dedicated link", "[demos][soak]") {
  DemoOptions options = quiet(1, 12.0);
  options.peers = 3;
  options.rates = {60.0, 72.0};
  const Report report = run(options);
  CHECK(report.fault == "");
  CHECK(report.metrics.resting_m.p50 <= 0.5e-3);
  CHECK(report.metrics.moving_m.p50 <= 5e-3);
  CHECK(report.metrics.contested_m.count > 100);
}

TEST_CASE("cubes: two peers agree across an ocean", "[demos][soak]") {
  const Report report = run(quiet(5, 17.0), CubesOptions{});
  CHECK(report.fault == "");
  CHECK(report.metrics.resting_m.p50 <= 0.5e-3);
  CHECK(report.metrics.moving_m.p50 <= 25e-3);
}

TEST_CASE("cubes: without agreement the peers drift apart", "[demos][soak]") {
  DemoOptions options = quiet(3, 12.0);
  const Report together = run(options);
  options.influence = 0.0;
  const Report apart = run(options);
  CHECK(apart.fault == "");
  CHECK(apart.metrics.divergence_m.p50 >= 5.0 * together.metrics.divergence_m.p50);
  CHECK(apart.metrics.divergence_m.p95 >= 5.0 * together.metrics.divergence_m.p95);
}

}  // namespace
}  // namespace tandem::demos::virtual_runner_test
