// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cost to the other peers if the second of four has a bad network, or a bad machine, for 6 s.
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "beside/networks.h"

namespace tandem::beside_bench {
namespace {

constexpr std::string_view kUsage =
    R"(usage: beside networks [options]
  --scene NAME   this one alone
  --seed N       (1)
)";

std::string cell(double value, double scale, const char* format) {
  if (value < 0.0) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), format, scale * value);
  return text;
}

void show(const std::vector<std::string>& scenes, std::uint64_t seed) {
  std::printf(
      "| Scene | What the second peer has from 2 to 8 s | largest gap, mm | others p95, mm | "
      "together "
      "after, s | at rest after, s | leap beyond the gap, mm |\n|---|---|---|---|---|---|---|\n");
  for (const std::string& scene : scenes) {
    for (const Troubled& line : troubled(scene, seed)) {
      std::printf("| %s | %s | %s | %s | %s | %s | %s |\n", line.scene.c_str(),
                  line.trouble.c_str(), cell(line.gap, 1e3, "%.1f").c_str(),
                  cell(line.others, 1e3, "%.2f").c_str(), cell(line.together, 1.0, "%.2f").c_str(),
                  cell(line.at_rest, 1.0, "%.2f").c_str(), cell(line.leap, 1e3, "%.1f").c_str());
      std::fflush(stdout);
    }
  }
}

int run(std::span<const std::string_view> words) {
  std::vector<std::string> scenes = {"cubes", "piano", "room", "tennis", "pile", "cliff"};
  std::uint64_t seed = 1;
  demos::read_arguments(words,
                        {{"--seed",
                          [&](demos::Argument& in) {
                            seed = in.number(std::uint64_t{0}, std::uint64_t{1} << 62,
                                             "an integer >= 0");
                          }},
                         {"--scene", [&](demos::Argument& in) { scenes = {in.text()}; }}},
                        [](std::string_view word) {
                          if (word != "networks") demos::refuse("the first word", word, "networks");
                        });
  show(scenes, seed);
  return 0;
}

}  // namespace
}  // namespace tandem::beside_bench

int main(int argc, char** argv) {
  return tandem::demos::program_main(argc, argv, tandem::beside_bench::kUsage,
                                     tandem::beside_bench::run);
}
