// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// All predictors on the same remote states: predictors [--scene NAME]... [options of the demos].
// Writes one line of CSV for each scene, profile, situation and predictor; without --scene all
// scenes, without --profile all profiles.
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comparison.h"
#include "measures/metrics.h"
#include "runner/virtual_runner.h"
#include "scenes/cliff.h"
#include "scenes/cubes.h"
#include "scenes/piano.h"
#include "scenes/room.h"
#include "scenes/tennis.h"
#include "session/options.h"

namespace {

using namespace tandem;

std::unique_ptr<demos::Scenario> scenario_of(std::string_view name) {
  if (name == "cubes") return std::make_unique<demos::CubesScenario>();
  if (name == "room") return std::make_unique<demos::RoomScenario>();
  if (name == "piano") {
    demos::PianoOptions piano;
    piano.soft = true;  // all users' springs are sent
    return std::make_unique<demos::PianoScenario>(piano);
  }
  if (name == "cliff") return std::make_unique<demos::CliffScenario>();
  if (name == "tennis") return std::make_unique<demos::TennisScenario>();
  demos::refuse("--scene", name, "cubes, room, piano, cliff or tennis");
}

void compare(std::string_view scene, const demos::DemoOptions& options) {
  const std::unique_ptr<demos::Scenario> scenario = scenario_of(scene);
  std::vector<consensus::SharedId> bodies;
  for (const demos::SceneBody& body : scenario->build({}).bodies) bodies.push_back(body.id);
  std::vector<bench::Comparison> comparisons;
  for (int i = 0; i < options.peers; ++i) comparisons.emplace_back(bodies);
  std::vector<consensus::PeerObserver*> observers;
  for (bench::Comparison& comparison : comparisons) observers.push_back(&comparison);
  const demos::RunResult result = demos::run_virtual(*scenario, options, nullptr, observers);

  bench::Errors errors;
  for (const bench::Comparison& comparison : comparisons) {
    bench::add_errors(comparison.trials(), result.peers, errors);
  }
  for (std::size_t s = 0; s < bench::kSituations; ++s) {
    std::vector<demos::Distribution> of;
    for (std::vector<double>& values : errors[s]) of.push_back(demos::distribution(values));
    if (of[0].count == 0) continue;
    const demos::Distribution& euler = of[1];
    for (std::size_t k = 0; k < bench::kKinds.size(); ++k) {
      std::printf("%s,%d,%llu,%s,%s,%s,%zu,%.9g,%.9g,%.9g,%.4g,%.4g\n", std::string(scene).c_str(),
                  options.profile, static_cast<unsigned long long>(options.seed),
                  std::string(demos::to_string(options.predictor_kind())).c_str(),
                  std::string(bench::to_string(static_cast<bench::Situation>(s))).c_str(),
                  std::string(demos::to_string(bench::kKinds[k])).c_str(), of[k].count,
                  1e3 * of[k].p50, 1e3 * of[k].p95, 1e3 * of[k].max, of[k].p50 / euler.p50,
                  of[k].p95 / euler.p95);
    }
  }
  std::fflush(stdout);
}

int run(std::span<const std::string_view> words) {
  std::vector<std::string_view> scenes;
  std::vector<std::string_view> others = {"--print", "nothing"};
  bool one_profile = false;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--scene") {
      scenes.push_back(++i < words.size() ? words[i] : "");
    } else {
      one_profile = one_profile || words[i].starts_with("--profile");
      others.push_back(words[i]);
    }
  }
  if (scenes.empty()) scenes = {"cubes", "room", "piano", "cliff", "tennis"};
  demos::DemoOptions options = demos::parse_options(others);
  std::puts(
      "scene,profile,seed,in_loop,situation,predictor,count,p50_mm,p95_mm,max_mm,"
      "p50_of_euler,p95_of_euler");
  for (const std::string_view scene : scenes) {
    if (one_profile) {
      compare(scene, options);
      continue;
    }
    for (options.profile = 1; options.profile <= 5; ++options.profile) compare(scene, options);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return demos::program_main(argc, argv, demos::usage_of_all("predictors [--scene NAME]..."), run);
}
