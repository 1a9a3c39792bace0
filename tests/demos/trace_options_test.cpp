// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "session/options.h"
#include "session/run_arguments.h"
#include "support/catch.h"

namespace tandem::demos::trace_options_test {
namespace {

/// Values other than the default one for all that a run has.
struct Sample {
  std::string_view name;
  std::string_view value;  ///< "" = it takes none
};
constexpr Sample kVirtual[] = {{"--peers", "3"},
                               {"--profile", "5"},
                               {"--link",
                                "loss=0.1,duplicate=0.2,reorder=0.30000000000000004,"
                                "bandwidth=1500,max-state=502,network=wifi"},
                               {"--clock", "none,spread=0.25,off-grid"}};
constexpr Sample kEverywhere[] = {{"--seconds", "7.5"},
                                  {"--seed", "77"},
                                  {"--influence", "0.123456789012345"},
                                  {"--coupling", "two-step-paper"},
                                  {"--mode", "asymmetric"},
                                  {"--predictor", "euler"},
                                  {"--agreement", "share=0.3,budget=7,inputs=common"},
                                  {"--send", "hz=30,compact,budget=64,tolerance=0.001"},
                                  {"--rates", "60,72.5"},
                                  {"--engines", "tandem,tandem"},
                                  {"--substeps", "7"},
                                  {"--iterations", "2,20"},
                                  {"--ablate", "initiative,leading"},
                                  {"--variant", "soft"}};
/// Options about output files and connections, or that repeat another option.
constexpr std::string_view kOthers[] = {
    "--transport", "--view",    "--listen",    "--connect", "--peer-id", "--key",
    "--wait",      "--script",  "--json",      "--csv",     "--record",  "--trace",
    "--help",      "--version", "--reference", "--print",   "--help-all"};

/// Options that begin a line or follow a comma or semicolon.
std::set<std::string_view> options_named_in(const std::string& help) {
  std::set<std::string_view> named;
  for (std::size_t at = help.find("  --"); at != std::string::npos; at = help.find(" --", at + 3)) {
    const std::size_t begin = help.find("--", at);
    const std::size_t end = help.find_first_of(" ,:;)|.\n", begin);
    named.insert(std::string_view(help).substr(begin, end - begin));
  }
  return named;
}

TEST_CASE("trace: the words of a run's options are read back as the same options",
          "[demos][unit]") {
  std::vector<std::string_view> words;
  const auto add = [&words](const Sample& sample) {
    words.push_back(sample.name);
    if (!sample.value.empty()) words.push_back(sample.value);
  };
  for (const Sample& sample : kVirtual) add(sample);
  for (const Sample& sample : kEverywhere) add(sample);
  const std::vector<std::string> written = run_arguments(parse_options(words));
  std::vector<std::string> expected(words.begin(), words.end());
  auto sorted = written;
  std::sort(sorted.begin(), sorted.end());
  std::sort(expected.begin(), expected.end());
  CHECK(sorted == expected);
  const std::vector<std::string_view> again(written.begin(), written.end());
  CHECK(run_arguments(parse_options(again)) == written);
  CHECK(run_arguments(DemoOptions{}).empty());

  const std::vector<std::string_view> network{"--connect", "localhost:7", "--peer-id", "4",
                                              "--key",     "secret",      "--send",    "budget=64"};
  CHECK(run_arguments(parse_options(network)) ==
        std::vector<std::string>{"--listen", "0", "--peer-id", "4", "--transport", "udp", "--send",
                                 "budget=64"});

  // A new option must be listed here as one on which a run depends or does not.
  std::set<std::string_view> known(std::begin(kOthers), std::end(kOthers));
  for (const Sample& sample : kVirtual) known.emplace(sample.name);
  for (const Sample& sample : kEverywhere) known.emplace(sample.name);
  const std::string all = usage_of_all("cubes");
  const std::set<std::string_view> named = options_named_in(all);
  CHECK(named == known);
  CHECK(named.size() <= 35);
  // --help shows at most ten of them.
  const std::string help = usage("cubes");
  const std::set<std::string_view> usual = options_named_in(help);
  CHECK(usual.size() <= 10);
  CHECK(std::includes(known.begin(), known.end(), usual.begin(), usual.end()));
}

}  // namespace
}  // namespace tandem::demos::trace_options_test
