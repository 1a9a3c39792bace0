// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "program/demo_main.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "measures/report.h"
#include "program/process_runner.h"
#include "recording/gltf.h"
#include "runner/virtual_runner.h"
#include "session/options.h"
#include "view/live_runner.h"

namespace tandem::demos {

namespace {

std::vector<std::string> body_names(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const SceneBody& body : scenario.build({}).bodies) names.push_back(body.name);
  return names;
}

int run(const Scenario& scenario, const DemoOptions& options) {
  if (options.view && !view::has_view()) {
    throw UsageError("--view needs a build with it: " + view::missing());
  }
  RunResult result = options.over_network() ? run_process(scenario, options)
                     : options.view         ? view::run_live(scenario, options)
                                            : run_virtual(scenario, options);
  // Nothing was kept of a session without an end.
  if (options.endless) return 0;
  std::optional<RunResult> reference;
  if (options.reference && !options.over_network()) {
    reference = run_reference(scenario, options, result);
  }
  if (!options.glb.empty()) write_glb(options.glb, scenario.build({}), result.peers);
  return publish(make_report(scenario.name(), options, std::move(result), body_names(scenario),
                             reference ? &*reference : nullptr));
}

}  // namespace

int demo_main(int argc, char** argv, const ScenarioFactory& factory) {
  return program_main(argc, argv, usage(program_name(argv[0])),
                      [&](std::span<const std::string_view> words) {
                        const DemoOptions options = parse_options(words);
                        check_results(options);
                        return run(*factory(options.variant), options);
                      });
}

}  // namespace tandem::demos
