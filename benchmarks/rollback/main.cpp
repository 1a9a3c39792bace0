// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Prediction with rollback compared with agreement and single owners: one scene, network and seed,
// a line per method. Fails if confirmed frames of rollback differ by a bit.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "arguments/arguments.h"
#include "measures/smoothness.h"
#include "measures/stretch.h"
#include "rollback/session.h"
#include "tandem/pbd/parse_number.h"

namespace tandem::rollback_bench {
namespace {

constexpr std::string_view kUsage =
    R"(usage: rollback [options]
  --scene NAME     cubes, room, piano, tennis, cliff (200 balls), pile (8 x 8), table (cubes)
  --variant NAME   of the piano, as of the demo: soft, mouse, tug
  --people N       peers (2); at the table all of them act
  --profile 0..5   of the network (3)
  --loss P         chance that a state is lost (0)
  --network NAME   of the second peer, as of the demos: wifi, swollen, lopsided, bursts
  --case NAME      plain, late (the last peer comes after 40 %), differ (6 substeps at the second)
  --seed N         (1)
  --seconds S      (20)
  --ways LIST      tandem, owner (carried on by velocity), owner-shown (as it comes),
                   rollback-DELAY[-EXTRAPOLATION[-SMOOTHING]]: frames, frames, ms
  --redundancy N   newest frames that each packet of rollback repeats (5)
  --header         print the names of the columns
)";

constexpr std::string_view kScenes[] = {"cubes", "room", "piano", "tennis",
                                        "cliff", "pile", "table"};
constexpr std::string_view kCases[] = {"plain", "late", "differ"};
constexpr double kJoinsAt = 0.4;   ///< fraction of the run, in "late"
constexpr int kOtherSubsteps = 6;  ///< in "differ"

struct Options {
  demos::DemoOptions demo;
  std::string scene = "cubes";
  std::string kind = "plain";  ///< of kCases
  int redundancy = 5;
  std::vector<std::string> ways = {"tandem", "owner", "owner-shown", "rollback-0", "rollback-3"};
};

/// m, per unowned body and frame in which it moves or is held, at the viewing peer: motion not
/// explained by its own velocities. A step uses one of the velocities at its ends, or a mixture at
/// an impact: the value is the distance from the line between both displacements.
demos::Distribution jumps(std::span<const demos::PeerRecord> peers) {
  std::vector<double> values;
  for (const demos::PeerRecord& peer : peers) {
    for (std::size_t body = 0; body < peer.tracks.size(); ++body) {
      if (peer.owned(body)) continue;
      const std::vector<demos::TrackSample>& track = peer.tracks[body].samples();
      for (std::size_t i = 1; i < track.size(); ++i) {
        const demos::TrackSample& a = track[i - 1];
        const demos::TrackSample& b = track[i];
        if (b.users == 0 && std::max(a.speed, b.speed) <= demos::kMovingSpeed) continue;
        const double dt = 1e-9 * static_cast<double>(b.time - a.time);
        const pbd::Vec3 way = dt * (b.velocity - a.velocity);
        const pbd::Vec3 rest = b.position - a.position - dt * a.velocity;
        const double square = way.squaredNorm();
        const double part = square > 0.0 ? std::clamp(rest.dot(way) / square, 0.0, 1.0) : 0.0;
        values.push_back((rest - part * way).norm());
      }
    }
  }
  return demos::distribution(values);
}

/// "rollback-3-6-100". @throws UsageError
RollbackOptions rollback_options(std::string_view way) {
  constexpr std::string_view kRule =
      "some of tandem, owner, owner-shown and rollback-DELAY[-EXTRAPOLATION[-SMOOTHING]], with at "
      "most 60 frames, 30 frames, 1000 ms";
  constexpr std::string_view kPrefix = "rollback-";
  constexpr int kMost[3] = {60, 30, 1000};
  int values[3] = {};
  if (!way.starts_with(kPrefix)) demos::refuse("--ways", way, kRule);
  std::string_view rest = way.substr(kPrefix.size());
  for (std::size_t i = 0;; ++i) {
    if (i == std::size(values)) demos::refuse("--ways", way, kRule);
    const std::size_t end = std::min(rest.find('-'), rest.size());
    const std::string_view text = rest.substr(0, end);
    if (!pbd::detail::parse_number(text, values[i]) || values[i] > kMost[i])
      demos::refuse("--ways", way, kRule);
    if (end == rest.size()) break;
    rest.remove_prefix(end + 1);
  }
  RollbackOptions options;
  options.input_delay = values[0];
  options.extrapolation = values[1];
  options.smoothing = 1e-3 * values[2];
  return options;
}

bool is_coupling(std::string_view way) {
  return way == "tandem" || way == "owner" || way == "owner-shown";
}

Run run(const demos::Scenario& scenario, const Options& options, const std::string& way) {
  const bool late = options.kind == "late";
  const auto join =
      static_cast<std::int64_t>(late ? kJoinsAt * options.demo.seconds * kFrameHz : 0.0);
  std::optional<int> substeps;
  if (options.kind == "differ") substeps = kOtherSubsteps;
  if (!is_coupling(way)) {
    RollbackOptions rollback = rollback_options(way);
    rollback.join = join;
    rollback.redundancy = options.redundancy;
    rollback.other_substeps = substeps;
    return run_rollback(scenario, options.demo, rollback);
  }
  demos::DemoOptions demo = options.demo;
  if (way != "tandem") demo.scheme = demos::Scheme::SingleOwner;
  if (way == "owner-shown") demo.predictor = consensus::PredictorKind::None;
  return run_coupling(scenario, demo, substeps, join);
}

/// s from the last peer's arrival until its bodies were within a centimetre of the first peer's; <
/// 0 = never.
double joined_after(const Run& run, double came) {
  constexpr double kLevel = 0.01;  // m
  const demos::PeerRecord two[] = {run.peers.front(), run.peers.back()};
  std::map<consensus::SessionTime, double> apart;
  for (const demos::DivergenceSample& sample : demos::divergence(two)) {
    double& most = apart[sample.time];
    if (sample.object != demos::ObjectClass::Owned) most = std::max(most, sample.distance);
  }
  for (const auto& [time, most] : apart) {
    const double after = 1e-9 * static_cast<double>(time - frame_time(0)) - came;
    if (after > 0.0 && most < kLevel) return after;
  }
  return -1.0;
}

/// Prints the results of a run, after the names of the columns if `header`.
void print(const Options& options, const std::string& way, Run& run, bool header) {
  const demos::Metrics m = demos::evaluate(run.peers);
  const demos::Distribution jump = jumps(run.peers);
  const demos::Stretch stretch = demos::stretch(run.peers);
  const demos::Distribution cpu = demos::distribution(run.frame_ms);
  const auto held = static_cast<std::size_t>(demos::ObjectClass::Held);
  const auto owned = static_cast<std::size_t>(demos::ObjectClass::Owned);
  double bytes = 0.0;
  double seconds = 0.0;
  std::string outcome;
  int faults = 0;
  for (const demos::PeerRecord& peer : run.peers) {
    bytes += static_cast<double>(peer.bytes_sent);
    seconds += peer.seconds;
    if (peer.fault.empty()) continue;
    if (faults++ == 0) outcome = peer.fault + "; ";
  }
  for (const auto& [name, value] : run.peers.front().outcome) {
    outcome += name + "=" + std::to_string(value) + " ";
  }
  std::replace(outcome.begin(), outcome.end(), ',', ';');
  const std::pair<const char*, double> columns[] = {
      {"moving_p50_mm", 1e3 * m.shared_moving_m.p50},
      {"moving_p95_mm", 1e3 * m.shared_moving_m.p95},
      {"moving_max_mm", 1e3 * m.shared_moving_m.max},
      {"all_p99_mm", 1e3 * m.divergence_m.p99},
      {"held_p95_mm", 1e3 * m.object_m[held].p95},
      {"owned_p95_mm", 1e3 * m.object_m[owned].p95},
      {"jump_p99_mm", 1e3 * jump.p99},
      {"jump_max_mm", 1e3 * jump.max},
      {"jerk_rms", demos::smoothness(run.peers).jerk_rms},
      {"stretch_one_p50_mm", 1e3 * stretch.one_m.p50},
      {"stretch_one_p95_mm", 1e3 * stretch.one_m.p95},
      {"stretch_several_p50_mm", 1e3 * stretch.several_m.p50},
      {"stretch_several_p95_mm", 1e3 * stretch.several_m.p95},
      {"cpu_mean_ms", cpu.mean},
      {"cpu_p50_ms", cpu.p50},
      {"cpu_p99_ms", cpu.p99},
      {"steps_per_frame", run.steps_per_frame},
      {"kbyte_per_s", 1e-3 * bytes / seconds},
      {"stalled", static_cast<double>(run.stalled)},
      {"confirmed", static_cast<double>(run.confirmed)},
      {"desync_frame", static_cast<double>(run.first_desync)},
      {"joined_s",
       options.kind == "late" ? joined_after(run, kJoinsAt * options.demo.seconds) : -1.0},
      {"snapshot_kbyte", 1e-3 * static_cast<double>(run.snapshot_bytes)},
      {"faults", static_cast<double>(faults)}};
  if (header) {
    std::printf("scene,variant,people,profile,loss,network,case,seed,way,");
    for (const auto& [name, value] : columns) std::printf("%s,", name);
    std::puts("outcome");
  }
  const demos::DemoOptions& demo = options.demo;
  std::printf("%s,%s,%d,%d,%g,%s,%s,%llu,%s,", options.scene.c_str(), demo.variant.c_str(),
              demo.peers, demo.profile, demo.loss, demo.network.c_str(), options.kind.c_str(),
              static_cast<unsigned long long>(demo.seed), way.c_str());
  for (const auto& [name, value] : columns) std::printf("%.5g,", value);
  std::puts(outcome.c_str());
  std::fflush(stdout);
}

std::vector<std::string_view> network_names() {
  std::vector<std::string_view> names;
  for (const consensus::NamedNetwork& network : consensus::named_networks()) {
    names.push_back(network.name);
  }
  return names;
}

/// @throws UsageError if the value is not in `allowed`
std::string one_of(demos::Argument& argument, std::span<const std::string_view> allowed) {
  const std::string value = argument.text();
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  std::string rule = "one of";
  for (const std::string_view word : allowed) rule.append(" ").append(word);
  demos::refuse(argument.name(), value, rule);
}

int compare(std::span<const std::string_view> words) {
  Options options;
  bool header = false;
  using demos::Argument;
  demos::read_arguments(
      words,
      {{"--scene", [&](Argument& a) { options.scene = one_of(a, kScenes); }},
       {"--variant", [&](Argument& a) { options.demo.variant = a.text(); }},
       {"--people", [&](Argument& a) { options.demo.peers = a.number(2, 6, "from 2 to 6"); }},
       {"--profile", [&](Argument& a) { options.demo.profile = a.number(0, 5, "from 0 to 5"); }},
       {"--loss", [&](Argument& a) { options.demo.loss = a.number(0.0, 0.9, "from 0 to 0.9"); }},
       {"--redundancy", [&](Argument& a) { options.redundancy = a.number(1, 60, "from 1 to 60"); }},
       {"--network", [&](Argument& a) { options.demo.network = one_of(a, network_names()); }},
       {"--case", [&](Argument& a) { options.kind = one_of(a, kCases); }},
       {"--seed",
        [&](Argument& a) {
          options.demo.seed = a.number<std::uint64_t>(0, UINT64_MAX, "a whole number");
        }},
       {"--seconds",
        [&](Argument& a) { options.demo.seconds = a.number(1.0, 600.0, "from 1 to 600 s"); }},
       {"--ways",
        [&](Argument& a) {
          options.ways.clear();
          for (const std::string_view way : demos::items_of(a.value())) {
            if (!is_coupling(way)) rollback_options(way);
            options.ways.emplace_back(way);
          }
        }},
       {"--header", [&](Argument&) { header = true; }}});
  const auto scenario = make_scenario(options.scene, options.demo.peers, options.demo.variant);
  if (!scenario) {
    demos::refuse("--variant", options.demo.variant, "soft, mouse or tug, and of the piano");
  }
  int code = 0;
  for (const std::string& way : options.ways) {
    Run result = run(*scenario, options, way);
    print(options, way, result, std::exchange(header, false));
    if (options.kind != "differ" && result.first_desync >= 0) code = 1;
  }
  return code;
}

}  // namespace
}  // namespace tandem::rollback_bench

int main(int argc, char** argv) {
  return tandem::demos::program_main(argc, argv, tandem::rollback_bench::kUsage,
                                     tandem::rollback_bench::compare);
}
