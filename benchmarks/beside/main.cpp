// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What one member costs honest ones: by states of any age, true or false (ages), or by its network
// (networks).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "arguments/arguments.h"
#include "beside/company.h"
#include "beside/networks.h"
#include "measures/metrics.h"
#include "tandem/pbd/random.h"

namespace tandem::beside_bench {
namespace {

constexpr std::string_view kUsage =
    R"(usage: beside ages|networks [options]
  --scene NAME   this one alone
ages: one member with states of any age beside honest ones
  --draws N      of one member with states of any age (200)
  --first N      number of the first draw (0)
  --honest N     so many alone
  --profile 1..5 this one alone
  --age S        of all states, s
  --truth        it tells the truth
  --seconds S    of each run (5)
networks: the second of four peers has a bad network, or a bad machine, for 6 s
  --seed N       (1)
)";

struct Options {
  int draws = 200;
  int first = 0;
  std::string scene;
  int honest = 0;
  double age = -1.0;
  double seconds = 5.0;
  bool truth = false;
  bool details = false;
  bool networks = false;
  std::uint64_t seed = 1;
  int profile = 0;
};

struct Draw {
  Company company;
  Saying saying;
};

Draw draw(std::uint64_t number) {
  pbd::SplitMix64 dice(number);
  dice.next();
  static constexpr std::string_view kScenes[] = {"cubes",  "piano", "room",
                                                 "tennis", "pile",  "cliff"};
  static constexpr int kHonest[] = {1, 2, 3, 6, 15};
  Draw out;
  out.company.scene = kScenes[dice.below(std::size(kScenes))];
  out.company.honest = kHonest[dice.below(std::size(kHonest))];
  out.company.profile = 1 + static_cast<int>(dice.below(5));
  Saying& saying = out.saying;
  // Half of the ages are about those of honest ones, where it is not told from them by its age.
  const auto age = [&] { return dice.uniform(0.0, dice.chance(0.5) ? 0.25 : 1.0); };
  saying.age = age();
  saying.other_age = dice.chance(0.5) ? saying.age : age();
  saying.mixed = dice.chance(0.3);
  saying.influence = std::pow(10.0, dice.uniform(-6.0, 0.0));
  if (dice.chance(0.5)) saying.influence = dice.uniform(0.02, 1.0);
  saying.aside = dice.chance(0.5) ? std::pow(10.0, dice.uniform(-2.0, 0.0)) : 0.0;
  saying.every = dice.chance(0.3) ? 20 : 1;
  saying.bodies = dice.chance(0.3) ? 1 : 10'000;
  saying.leads = dice.chance(0.25);
  return out;
}

using Key = std::tuple<std::string, int, int, std::uint64_t>;

std::string cell(double value, double scale, const char* format) {
  if (value < 0.0) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), format, scale * value);
  return text;
}

int show_networks(const Options& options) {
  std::vector<std::string> scenes = {"cubes", "piano", "room", "tennis", "pile", "cliff"};
  if (!options.scene.empty()) scenes = {options.scene};
  std::printf(
      "| Scene | What the second peer has from 2 to 8 s | largest gap, mm | others p95, mm | "
      "together "
      "after, s | at rest after, s | leap beyond the gap, mm |\n|---|---|---|---|---|---|---|\n");
  for (const std::string& scene : scenes) {
    for (const Troubled& line : troubled(scene, options.seed)) {
      std::printf("| %s | %s | %s | %s | %s | %s | %s |\n", line.scene.c_str(),
                  line.trouble.c_str(), cell(line.gap, 1e3, "%.1f").c_str(),
                  cell(line.others, 1e3, "%.2f").c_str(), cell(line.together, 1.0, "%.2f").c_str(),
                  cell(line.at_rest, 1.0, "%.2f").c_str(), cell(line.leap, 1e3, "%.1f").c_str());
      std::fflush(stdout);
    }
  }
  return 0;
}

int show_ages(const Options& options) {
  std::map<Key, Outcome> alone;
  int failed = 0;
  std::printf("%5s %-6s %6s %7s %4s  %5s %5s %5s %8s %6s %5s %6s %5s  %9s %9s %9s %9s %5s %7s\n",
              "draw", "scene", "honest", "profile", "seed", "age", "other", "mixed", "weight",
              "aside", "every", "bodies", "leads", "p50,mm", "without", "p95,mm", "without", "work",
              "no target");
  for (int i = 0; i < options.draws; ++i) {
    const int number = options.first + i;
    Draw drawn = draw(static_cast<std::uint64_t>(number));
    if (!options.scene.empty() && drawn.company.scene != options.scene) continue;
    if (options.honest > 0 && drawn.company.honest != options.honest) continue;
    if (options.profile > 0) drawn.company.profile = options.profile;
    if (options.truth) drawn.saying.aside = 0.0;
    drawn.company.seconds = options.seconds;
    drawn.company.seed = options.seed;
    if (options.age >= 0.0) drawn.saying.age = drawn.saying.other_age = options.age;
    const Company& company = drawn.company;
    const Saying& saying = drawn.saying;
    const Key key{company.scene, company.honest, company.profile, company.seed};
    auto known = alone.find(key);
    if (known == alone.end()) known = alone.emplace(key, beside_bench::run(company, nullptr)).first;
    const Outcome& without = known->second;
    const Outcome with = beside_bench::run(company, &saying);
    double p50 = with.p50;
    double p95 = with.p95;
    double no_target = 0.0;
    for (std::size_t k = 0; k < with.replays.size(); ++k) {
      const auto more = static_cast<double>(with.replays[k].without) -
                        static_cast<double>(without.replays[k].without);
      no_target = std::max(no_target, more / with.steps);
    }
    if (company.honest == 1) {
      // Beside its own way without it.
      const std::vector<demos::PeerRecord> both = {without.records[0], with.records[0]};
      std::vector<double> way;
      for (const auto& sample : demos::divergence(both)) {
        if (sample.object != demos::ObjectClass::Owned) way.push_back(sample.distance);
      }
      const demos::Distribution found = demos::distribution(way);
      p50 = found.p95;
      p95 = found.max;
    }
    const double work = static_cast<double>(with.body_steps) /
                        static_cast<double>(std::max<std::uint64_t>(1, without.body_steps));
    const bool same = with.worlds == without.worlds;
    const bool holds = company.honest == 1 ? p95 <= 0.01 && no_target <= 0.01
                                           : !(p50 > 1.2 * without.p50 + 1e-4) &&
                                                 !(p95 > 1.2 * without.p95 + 1e-4) && work <= 1.3 &&
                                                 no_target <= 0.01;
    failed += holds ? 0 : 1;
    std::printf(
        "%5d %-6s %6d %7d %4d  %5.3f %5.3f %5d %8.2g %6.3f %5d %6s %5d  %9.3f %9.3f %9.3f %9.3f "
        "%5.2f %6.1f%% "
        "%s%s\n",
        number, company.scene.c_str(), company.honest, company.profile,
        static_cast<int>(company.seed), saying.age, saying.other_age, saying.mixed,
        saying.influence, saying.aside, saying.every, saying.bodies == 1 ? "one" : "all",
        saying.leads, 1e3 * p50, 1e3 * without.p50, 1e3 * p95, 1e3 * without.p95, work,
        1e2 * no_target, holds ? "ok" : "NO", same ? " same" : "");
    if (options.details) {
      for (const Outcome* one : {&without, &with}) {
        for (const consensus::ReplayStats& replay : one->replays) {
          std::printf("  fresh %d, along %d, without %d, steps %d, body steps %d\n",
                      int(replay.fresh), int(replay.postponed), int(replay.without),
                      int(replay.steps), int(replay.body_steps));
        }
        std::printf("  all body steps %d\n", int(one->body_steps));
      }
    }
    std::fflush(stdout);
  }
  std::printf("%d do not hold\n", failed);
  return failed == 0 ? 0 : 1;
}

Options read_options(std::span<const std::string_view> words) {
  Options out;
  demos::read_arguments(
      words,
      {{"--draws", [&](demos::Argument& in) { out.draws = in.number(1, 1'000'000, "a number"); }},
       {"--first", [&](demos::Argument& in) { out.first = in.number(0, 1'000'000, "a number"); }},
       {"--honest", [&](demos::Argument& in) { out.honest = in.number(1, 64, "from 1 to 64"); }},
       {"--age", [&](demos::Argument& in) { out.age = in.number(0.0, 1.0, "0 to 1 s"); }},
       {"--details", [&](demos::Argument&) { out.details = true; }},
       {"--truth", [&](demos::Argument&) { out.truth = true; }},
       {"--profile", [&](demos::Argument& in) { out.profile = in.number(1, 5, "1 to 5"); }},
       {"--seconds",
        [&](demos::Argument& in) { out.seconds = in.number(2.5, 60.0, "2.5 to 60 s"); }},
       {"--seed",
        [&](demos::Argument& in) {
          out.seed = in.number(std::uint64_t{0}, std::uint64_t{1} << 62, "an integer >= 0");
        }},
       {"--scene", [&](demos::Argument& in) { out.scene = in.text(); }}},
      [&](std::string_view word) {
        if (word != "ages" && word != "networks")
          demos::refuse("the first word", word, "ages or networks");
        out.networks = word == "networks";
      });
  return out;
}

}  // namespace
}  // namespace tandem::beside_bench

int main(int argc, char** argv) {
  using namespace tandem;
  return demos::program_main(argc, argv, beside_bench::kUsage, [](auto words) {
    const beside_bench::Options options = beside_bench::read_options(words);
    return options.networks ? beside_bench::show_networks(options)
                            : beside_bench::show_ages(options);
  });
}
