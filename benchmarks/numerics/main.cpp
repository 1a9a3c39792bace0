// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The numerics set as one table: result, reference and bound, for Tandem and the other engines of
// this build.
//   numerics [--csv FILE] [--only TEXT] [--engine tandem|bullet64|jolt|...] [--list]
// Exit code 1 if a line of Tandem fails without a known entry.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "arguments/arguments.h"
#include "measure/clock.h"
#include "numerics/case.h"
#include "peers/engines.h"

namespace tandem::bench {
namespace {

struct Options {
  std::string csv, only, engine;
  bool list = false;
};

constexpr std::string_view kUsage =
    "usage: numerics [--csv FILE] [--only TEXT] [--engine tandem|bullet64|jolt|...] [--list]\n";

Options parse(std::span<const std::string_view> words) {
  Options options;
  demos::read_arguments(words,
                        {{"--list", [&](demos::Argument&) { options.list = true; }},
                         {"--csv", [&](demos::Argument& in) { options.csv = in.text(); }},
                         {"--only", [&](demos::Argument& in) { options.only = in.text(); }},
                         {"--engine", [&](demos::Argument& in) { options.engine = in.text(); }}});
  return options;
}

std::string text(double value) {
  if (std::isnan(value)) return "-";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

class Table {
 public:
  explicit Table(const std::string& csv) {
    if (csv.empty()) return;
    file_.open(csv);
    if (!file_) throw std::runtime_error("cannot write " + csv);
    file_ << "engine,family,case,measure,value,reference,error,bound,unit,source,pass\n";
  }
  void header() {
    std::printf("%-11s%-51s%-40s%13s%13s%11s%9s  %-6s %s\n", "engine", "case", "measure", "value",
                "reference", "error", "bound", "holds", "source");
  }
  void line(const std::string& engine, const Case& c, const Check& check, const char* holds) {
    std::printf("%-11s%-51s%-40s%13s%13s%11s%9s  %-6s %s\n", engine.c_str(), c.name.c_str(),
                check.measure.c_str(), text(check.value).c_str(), text(check.reference).c_str(),
                text(check.error).c_str(), text(check.bound).c_str(), holds, check.source.c_str());
    std::fflush(stdout);
    csv(engine, c, check.measure, text(check.value), text(check.reference), text(check.error),
        text(check.bound), check.unit, check.source, holds);
  }
  void not_built(const std::string& engine, const Case& c, const std::string& why) {
    std::printf("%-11s%-51snot built: %s\n", engine.c_str(), c.name.c_str(), why.c_str());
    csv(engine, c, "", "", "", "", "", "", why, "n/a");
  }

 private:
  template <class... Texts>
  void csv(const std::string& engine, const Case& c, const Texts&... texts) {
    if (!file_.is_open()) return;
    file_ << engine << ',' << c.family << ",\"" << c.name << '"';
    ((file_ << ",\"" << texts << '"'), ...);
    file_ << '\n';
  }

  std::ofstream file_;
};

int run(const Options& options) {
  if (options.list) {
    for (const Case& c : all_cases()) std::printf("%s: %s\n", c.family.c_str(), c.name.c_str());
    return 0;
  }
  Table table(options.csv);
  table.header();
  int failures = 0;
  int known = 0;
  int lines = 0;
  for (const Case& c : all_cases()) {
    if (c.name.find(options.only) == std::string::npos) continue;
    for (const auto& [engine, make] : built_engines()) {
      if (!options.engine.empty() && engine != options.engine) continue;
      const bool ours = engine == "tandem";
      if (c.tandem_only && !ours) continue;
      const double begin = thread_seconds();
      const Outcome outcome = run_case(c, make);
      if (!outcome.not_built.empty()) {
        table.not_built(engine, c, outcome.not_built);
        if (ours) ++(known_failure(c.name, "").empty() ? failures : known);
        continue;
      }
      for (const Check& check : outcome.checks) {
        const bool is_known = ours && !known_failure(c.name, check.measure).empty();
        table.line(engine, c, check, check.holds() ? "yes" : is_known ? "known" : "NO");
        if (!ours) continue;
        ++lines;
        if (!check.holds()) ++(is_known ? known : failures);
      }
      const double seconds = thread_seconds() - begin;
      if (seconds > 1.0)
        std::fprintf(stderr, "%s, %s: %.1f s\n", c.name.c_str(), engine.c_str(), seconds);
    }
  }
  std::printf("Tandem: %d lines, %d do not hold, %d more are known not to\n", lines, failures,
              known);
  return failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) {
  using namespace tandem;
  return demos::program_main(argc, argv, bench::kUsage,
                             [](auto words) { return bench::run(bench::parse(words)); });
}
