// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors

// Stiff and extreme scenes with two and more peers. Prints one line of CSV per scene, scheme, link
// and seed; see Result for the columns.

#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "cost.h"
#include "run.h"

namespace {

using namespace tandem::extreme_bench;

struct Options {
  std::string group, scene, scheme;
  std::vector<std::string> links;
  double share = 0.0;  ///< 0 = the default
  int seeds = 3;
  bool cost = false;
};

constexpr std::string_view kUsage =
    "usage: extreme [--group G] [--scene PART] [--scheme S] [--link L] [--share S] [--seeds N]\n"
    "       extreme --cost\n"
    "  --link: frames of delay, or \"profile 5\"; several may be given. --share: announced by "
    "all, and part of a gap closed per 1/60 s\n";

Options parse(std::span<const std::string_view> words) {
  using tandem::demos::Argument;
  Options options;
  tandem::demos::read_arguments(
      words, {{"--cost", [&](Argument&) { options.cost = true; }},
              {"--group", [&](Argument& in) { options.group = in.text(); }},
              {"--scene", [&](Argument& in) { options.scene = in.text(); }},
              {"--scheme", [&](Argument& in) { options.scheme = in.text(); }},
              {"--link", [&](Argument& in) { options.links.push_back(in.text()); }},
              {"--share",
               [&](Argument& in) { options.share = in.number(0.0, 1.0, "a number from 0 to 1"); }},
              {"--seeds", [&](Argument& in) {
                 options.seeds = in.number(1, 1'000'000, "a whole number, 1 or more");
               }}});
  return options;
}

std::vector<Scene> all_scenes() {
  std::vector<Scene> all = contact_scenes();
  for (auto* more : {&stiff_scenes, &condition_scenes, &topology_scenes}) {
    for (Scene& scene : (*more)()) all.push_back(std::move(scene));
  }
  return all;
}

void print(const Scene& scene, const Scheme& scheme, const std::string& link, double share,
           int seed, const Result& r) {
  std::printf("%s,\"%s\",%d,%s,%s,%g,%d,%d,%.5g,%.5g,%d,%d,%d,%.4g,%.4g,%.4g,%.5g,%.5g,%.4g,%.4g\n",
              scene.group.c_str(), scene.name.c_str(), scene.peers, scheme.name.data(),
              link.c_str(), share, seed, r.stable ? 1 : 0, r.peak_mm, r.final_mm, r.half_frames,
              r.percent_frames, r.millimetre_frames, r.overlap_mm, r.overlap_end_mm, r.joint_mm,
              r.kinetic_J, r.work_J, r.excess_J, r.displacement_J);
}

bool random(const Scene& scene, const std::string& link) {
  const Conditions& c = scene.conditions;
  return link == "profile 5" || c.noise > 0.0 || c.noise_angle > 0.0 || c.loss > 0.0;
}

void run_links(const Options& options, const Scene& scene, const Scheme& scheme) {
  std::vector<std::string> links = options.links;
  if (links.empty()) links = {"0", "3", "7", "profile 5"};
  for (const std::string& link : links) {
    const int seeds = random(scene, link) ? options.seeds : 1;
    for (int seed = 1; seed <= seeds; ++seed) {
      const Result result = run(scene, scheme, link, static_cast<std::uint64_t>(seed));
      print(scene, scheme, link, options.share, seed, result);
      std::fflush(stdout);
    }
  }
}

void run_all(const Options& options) {
  for (Scene& scene : all_scenes()) {
    if (!options.group.empty() && scene.group != options.group) continue;
    if (scene.name.find(options.scene) == std::string::npos) continue;
    if (options.share > 0.0) {
      scene.conditions.share = options.share;
      scene.conditions.closing_share = options.share;
    }
    for (const Scheme& scheme : kSchemes) {
      if (!options.scheme.empty() && scheme.name != options.scheme) continue;
      run_links(options, scene, scheme);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  return tandem::demos::program_main(
      argc, argv, kUsage, [](std::span<const std::string_view> words) {
        const Options options = parse(words);
        if (options.cost) {
          print_costs();
          return 0;
        }
        std::puts(
            "group,scene,peers,scheme,link,share,seed,stable,peak_mm,final_mm,half_frames,"
            "percent_frames,millimetre_frames,overlap_mm,overlap_end_mm,joint_mm,"
            "kinetic_J,work_J,excess_J,displacement_J");
        run_all(options);
        return 0;
      });
}
