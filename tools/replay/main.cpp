// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Replays a peer from its trace. docs/trace.md
#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "replay/diff.h"
#include "replay/reader.h"
#include "replay/replayer.h"
#include "scenes/scenario_list.h"
#include "tandem/pbd/validate.h"
#include "trace/build_facts.h"

namespace {

using namespace tandem::demos;

constexpr std::string_view kUsage =
    "usage: tandem-replay TRACE          replay the peer and compare: 0 = bit-exact, 1 = not,\n"
    "                                    2 = the trace cannot be run here\n"
    "       tandem-replay --info TRACE   describe it\n"
    "       tandem-replay --diff A B     two runs of one peer: their first difference; two peers\n"
    "                                    of one session: where copies are farther apart than\n"
    "         --tolerance M              m (0.05)\n";

/// A trace in memory, read to its end.
struct Trace {
  std::string path;
  std::vector<char> content;
  TraceHeader header;
  std::uint64_t steps = 0;
  std::uint64_t packets = 0;
  std::uint64_t packet_bytes = 0;
  std::uint64_t inputs = 0;
  tandem::consensus::SessionTime first = 0, last = 0;  ///< ns
  bool complete = false;
  std::size_t end = 0;  ///< bytes read

  std::span<const std::byte> bytes() const { return std::as_bytes(std::span(content)); }
};

Trace read_trace(const std::string& path) {
  Trace trace;
  trace.path = path;
  std::ifstream file(path, std::ios::binary);
  trace.content.assign(std::istreambuf_iterator<char>(file), {});
  if (!file) throw std::runtime_error("must be a file that can be read");
  TraceReader reader(trace.bytes());
  trace.header = reader.header();
  TraceRecord record;
  while (reader.next(record)) {
    if (record.kind == TraceKind::Inputs) trace.inputs += record.inputs.size();
    if (record.kind == TraceKind::Begin && trace.first == 0) trace.first = record.time;
    if (record.kind == TraceKind::Step) trace.last = record.time;
    if (record.kind != TraceKind::Packets) continue;
    trace.packets += record.packets.size();
    for (const auto& packet : record.packets) trace.packet_bytes += packet.bytes.size();
  }
  trace.steps = reader.steps();
  trace.complete = reader.complete();
  trace.end = reader.offset();
  return trace;
}

std::unique_ptr<Scenario> scenario_of(const Trace& trace) {
  auto scenario = make_scenario(trace.header.scene, traced_options(trace.header.arguments).variant);
  if (scenario == nullptr) {
    tandem::pbd::detail::refuse("scene", "one that is known here", trace.header.scene);
  }
  return scenario;
}

std::string command(const Trace& trace) {
  std::string words = trace.header.scene;
  for (const std::string& argument : trace.header.arguments) words += ' ' + argument;
  return words;
}

void warn(const Trace& trace) {
  if (!trace.complete) {
    std::fprintf(stderr, "%s: cut off at byte %zu, after %llu steps\n", trace.path.c_str(),
                 trace.end, static_cast<unsigned long long>(trace.steps));
  }
  if (trace.header.build != build_facts()) {
    std::fprintf(stderr, "%s: of another build, its bits may differ\n  there: %s\n  here:  %s\n",
                 trace.path.c_str(), trace.header.build.c_str(), build_facts().c_str());
  }
}

std::string name_of(const Scenario& scenario, const Departure& departure) {
  return departure.body ? scenario.build({}).bodies[*departure.body].name : "";
}

int info(const Trace& trace) {
  const TraceHeader& h = trace.header;
  std::printf("scene     %s, %u bodies, hash %016llx\n", h.scene.c_str(), h.bodies,
              static_cast<unsigned long long>(h.scene_hash));
  std::printf("options   %s\n", command(trace).c_str());
  std::printf("peer      %llu (number %llu)\n", static_cast<unsigned long long>(h.self),
              static_cast<unsigned long long>(h.number));
  std::printf("build     %s\n", h.build.c_str());
  std::printf("steps     %llu, %.3f s\n", static_cast<unsigned long long>(trace.steps),
              1e-9 * static_cast<double>(trace.last - trace.first));
  std::printf("inbox     %llu packets, %llu bytes\n",
              static_cast<unsigned long long>(trace.packets),
              static_cast<unsigned long long>(trace.packet_bytes));
  std::printf("inputs    %llu\n", static_cast<unsigned long long>(trace.inputs));
  std::printf("file      %zu bytes, %s\n", trace.content.size(),
              trace.complete ? "complete" : "cut off");
  return 0;
}

int replay(const Trace& trace) {
  warn(trace);
  const std::unique_ptr<Scenario> scenario = scenario_of(trace);
  Replayer replayer(*scenario, trace.bytes());
  while (replayer.next_step()) {
  }
  if (const auto& departure = replayer.departure()) {
    std::printf("differs at %s\n", to_text(*departure, name_of(*scenario, *departure)).c_str());
    return 1;
  }
  std::printf("%llu steps, bit-exact\n", static_cast<unsigned long long>(replayer.steps()));
  return 0;
}

int diff_runs(const Trace& a, const Trace& b) {
  if (a.header.arguments != b.header.arguments) {
    std::fprintf(stderr, "of other options\n  %s\n  %s\n", command(a).c_str(), command(b).c_str());
  }
  TraceReader first(a.bytes());
  TraceReader second(b.bytes());
  if (const auto difference = first_difference(first, second)) {
    const std::unique_ptr<Scenario> scenario = scenario_of(a);
    std::printf("differ at %s\n", to_text(*difference, name_of(*scenario, *difference)).c_str());
    return 1;
  }
  const auto steps = static_cast<unsigned long long>(std::min(a.steps, b.steps));
  std::printf("%llu steps, the same\n", steps);
  if (a.steps != b.steps) {
    std::printf("one has %llu more\n",
                static_cast<unsigned long long>(std::max(a.steps, b.steps)) - steps);
  }
  return a.steps == b.steps ? 0 : 1;
}

int diff_views(const Trace& a, const Trace& b, double tolerance) {
  const DemoOptions options = traced_options(a.header.arguments);
  if (options.over_network() && options.timeline == Timeline::None) {
    throw std::runtime_error("must be of two peers with one time, is of --clock none");
  }
  const std::unique_ptr<Scenario> scenario = scenario_of(a);
  const TwoViews views = compare_views(*scenario, a.bytes(), b.bytes(), tolerance);
  for (const auto* departure : {&views.a, &views.b}) {
    if (!*departure) continue;
    std::printf("%s: the replay differs at %s\n", (departure == &views.a ? a : b).path.c_str(),
                to_text(**departure, name_of(*scenario, **departure)).c_str());
  }
  const std::vector<SceneBody> bodies = scenario->build({}).bodies;
  const auto tell = [&bodies](const char* what, const Apart& apart) {
    std::printf("%s at step %llu (session time %.6f s): body %s, %.3f mm\n", what,
                static_cast<unsigned long long>(apart.step), 1e-9 * static_cast<double>(apart.time),
                bodies[apart.body].name.c_str(), 1e3 * apart.distance);
  };
  std::printf("peers %llu and %llu, %llu steps compared\n",
              static_cast<unsigned long long>(a.header.self),
              static_cast<unsigned long long>(b.header.self),
              static_cast<unsigned long long>(views.compared));
  if (views.beyond) tell("apart", *views.beyond);
  if (views.furthest) tell("furthest", *views.furthest);
  return views.beyond || views.a || views.b ? 1 : 0;
}

int diff(const Trace& a, const Trace& b, double tolerance) {
  warn(a);
  warn(b);
  const bool one_scene = a.header.scene == b.header.scene &&
                         a.header.scene_hash == b.header.scene_hash &&
                         a.header.bodies == b.header.bodies;
  if (!one_scene) throw std::runtime_error("must be of the scene of " + a.path + ", is of another");
  if (a.header.self == b.header.self) return diff_runs(a, b);
  return diff_views(a, b, tolerance);
}

struct Arguments {
  std::vector<std::string> files;
  bool info = false;
  bool diff = false;
  double tolerance = 0.05;  ///< m
};

/// @throws UsageError
Arguments read(std::span<const std::string_view> words) {
  Arguments result;
  read_arguments(
      words,
      {{"--info", [&](Argument&) { result.info = true; }},
       {"--diff", [&](Argument&) { result.diff = true; }},
       {"--tolerance",
        [&](Argument& in) { result.tolerance = in.number(0.0, 1e6, "a number from 0 to 1e6 m"); }}},
      [&](std::string_view word) { result.files.emplace_back(word); });
  if (result.info && result.diff) throw UsageError("--info has no meaning with --diff");
  const std::size_t files = result.diff ? 2 : 1;
  if (result.files.size() != files) {
    throw UsageError(tandem::pbd::detail::must_be("number of traces", "two with --diff, else one",
                                                  static_cast<double>(result.files.size())));
  }
  return result;
}

int run(std::span<const std::string_view> words) {
  const Arguments arguments = read(words);
  std::string path;
  try {
    std::vector<Trace> traces;
    for (const std::string& file : arguments.files) {
      path = file;
      traces.push_back(read_trace(file));
    }
    if (arguments.info) return info(traces[0]);
    return arguments.diff ? diff(traces[0], traces[1], arguments.tolerance) : replay(traces[0]);
  } catch (const std::exception& error) {
    // A trace that cannot be run here is a usage error.
    throw UsageError(path + ": " + error.what());
  }
}

}  // namespace

int main(int argc, char** argv) { return program_main(argc, argv, kUsage, run); }
