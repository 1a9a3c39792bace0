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
#include "measures/story.h"
#include "program/process_runner.h"
#include "recording/gltf.h"
#include "runner/progress.h"
#include "runner/virtual_runner.h"
#include "session/option_values.h"
#include "session/options.h"
#include "view/live_runner.h"

namespace tandem::demos {

namespace {

std::vector<std::string> body_names(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const SceneBody& body : scenario.build({}).bodies) names.push_back(body.name);
  return names;
}

/// The coupling of the comparison run, if there is one.
std::optional<Scheme> shown_beside(const Scenario& scenario, const DemoOptions& o) {
  if (o.quiet() || o.alone || o.view || o.over_network()) return std::nullopt;
  if (o.beside) return o.beside;
  // A coupling asked for by name is run alone.
  const bool plain = o.scheme == Scheme::OnePass && o.influence > 0.0 && !o.ablation.any();
  if (!plain || o.print == Print::Details || !o.json.empty() || o.peers < 2) return std::nullopt;
  return scheme("baseline", scenario.baseline());
}

/// The same session with another coupling and without output files.
DemoOptions with(DemoOptions options, Scheme scheme) {
  options.scheme = scheme;
  options.trace.clear();
  return options;
}

std::string words_for(const Scenario& scenario, const Report& report, const Report* beside) {
  const DemoOptions& o = report.options;
  if (o.quiet()) return {};
  if (o.print == Print::Story) return story(scenario, report, beside, may_colour(words_go_to(o)));
  return report_table(report) + (beside != nullptr ? report_table(*beside) : std::string());
}

int run(const Scenario& scenario, const DemoOptions& options) {
  if (options.view && !view::has_view()) {
    throw UsageError("--view needs a build with it: " + view::missing());
  }
  if (options.hands.size() > scenario.user_count()) {
    refuse("--script hands=", std::to_string(options.hands.size()),
           "at most " + std::to_string(scenario.user_count()) + " files here");
  }
  const std::optional<Scheme> other = shown_beside(scenario, options);
  const bool again = options.reference && !options.over_network();
  std::optional<RunResult> reference, beside;
  RunResult result;
  if (options.over_network()) {
    result = run_process(scenario, options);
  } else {
    Progress progress(options.quiet(), 1 + (again ? 1 : 0) + (other ? 1 : 0));
    result = options.view ? view::run_live(scenario, options)
                          : run_virtual(scenario, options, nullptr, &progress);
    // An endless session keeps no record.
    if (!options.endless && again) reference = run_reference(scenario, options, result, &progress);
    if (other) {
      beside = run_virtual(scenario, with(options, *other), nullptr, &progress);
    }
  }
  if (options.endless) return 0;
  if (!options.glb.empty()) write_glb(options.glb, scenario.build({}), result.peers);
  const std::vector<std::string> names = body_names(scenario);
  const Report report = make_report(scenario.name(), options, std::move(result), names,
                                    reference ? &*reference : nullptr);
  std::optional<Report> report_beside;
  if (beside) {
    report_beside = make_report(scenario.name(), with(options, *other), *std::move(beside), names);
  }
  return publish(report, words_for(scenario, report, report_beside ? &*report_beside : nullptr));
}

}  // namespace

int demo_main(int argc, char** argv, const ScenarioFactory& factory) {
  const std::string program = program_name(argv[0]);
  return program_main(
      argc, argv, usage(program),
      [&](std::span<const std::string_view> words) {
        const DemoOptions options = parse_options(words);
        check_results(options);
        return run(*factory(options.variant), options);
      },
      usage_of_all(program));
}

}  // namespace tandem::demos
