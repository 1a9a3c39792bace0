// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Everyday scenes with many variations, and the worst case of each group beside its bound.
//   everyday [--engine jolt] [--kind E4] [--only TEXT] [--quick] [--json FILE] [--cases] [--list]
// Exit code 1 if a line of Tandem fails without a known entry, or a known entry holds in all cases.
// Other engines are not judged; cases that an adapter lacks are left out.
#include <cstdio>
#include <fstream>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/arguments.h"
#include "everyday/group.h"
#include "measure/clock.h"
#include "peers/engines.h"

namespace tandem::everyday {
namespace {

struct Options {
  std::string engine = "tandem", kind, only, json;
  bool quick = false, cases = false, list = false;
};

constexpr std::string_view kUsage =
    "usage: everyday [--engine NAME] [--kind E4] [--only TEXT] [--quick] [--json FILE] [--cases] "
    "[--list]\n"
    "  --engine     another engine of this build, at its defaults\n"
    "  --only TEXT  groups with it in name or ground\n"
    "  --quick      a few cases of some groups\n"
    "  --cases      each case beyond its bound, on standard error\n";

Options parse(std::span<const std::string_view> words) {
  Options options;
  using demos::Argument;
  demos::read_arguments(words, {{"--engine", [&](Argument& in) { options.engine = in.text(); }},
                                {"--kind", [&](Argument& in) { options.kind = in.text(); }},
                                {"--only", [&](Argument& in) { options.only = in.text(); }},
                                {"--json", [&](Argument& in) { options.json = in.text(); }},
                                {"--quick", [&](Argument&) { options.quick = true; }},
                                {"--cases", [&](Argument&) { options.cases = true; }},
                                {"--list", [&](Argument&) { options.list = true; }}});
  return options;
}

/// Lines as text and as JSON.
class Table {
 public:
  explicit Table(const std::string& json) {
    if (!json.empty()) {
      file_.open(json);
      if (!file_) throw std::runtime_error("cannot write " + json);
      file_ << "[";
    }
    std::printf("%-5s%-38s%-21s%-26s%7s%12s%11s %-7s%s\n", "kind", "what", "ground", "measure",
                "cases", "worst", "bound", "", "holds");
  }
  ~Table() {
    if (file_.is_open()) file_ << "\n]\n";
  }
  void line(const Line& line, const char* holds) {
    std::printf("%-5s%-38s%-21s%-26s%7d%12.4g%11.4g %-7s%s\n", line.kind.c_str(), line.name.c_str(),
                line.ground.c_str(), line.measure.c_str(), line.cases, line.worst, line.bound,
                line.unit.c_str(), holds);
    std::fflush(stdout);
    if (!file_.is_open()) return;
    char numbers[160];
    // JSON has no infinity.
    std::snprintf(numbers, sizeof numbers, R"("cases":%d,"beyond":%d,"worst":%.6g,"bound":%.6g,)",
                  line.cases, line.beyond, line.worst < 1e300 ? line.worst : 1e300, line.bound);
    file_ << (first_ ? "\n" : ",\n") << R"({"kind":")" << line.kind << R"(","name":")" << line.name
          << R"(","ground":")" << line.ground << R"(","measure":")" << line.measure << "\","
          << numbers << R"("unit":")" << line.unit << R"(","worst_case":")" << line.worst_case
          << R"(","holds":")" << holds << "\"}";
    first_ = false;
  }

 private:
  bool first_ = true;
  std::ofstream file_;
};

bool asked_for(const Group& group, const Options& options) {
  return (options.kind.empty() || group.kind == options.kind) && (!options.quick || group.quick) &&
         (group.name + ", " + group.ground).find(options.only) != std::string::npos;
}

/// Lines that hold, that fail, and that are known to fail.
class Verdict {
 public:
  explicit Verdict(bool judged) : judged_(judged) {}
  const char* take(const Line& line) {
    ++lines_;
    if (!judged_) {
      failures_ += line.holds() ? 0 : 1;
      return line.holds() ? "ok" : "no";
    }
    const int entry = known_entry(line);
    if (entry >= 0) failed_of_[entry] += line.holds() ? 0 : 1;
    if (line.holds()) return "ok";
    ++(entry >= 0 ? known_ : failures_);
    return entry >= 0 ? "known" : "FAILS";
  }
  /// @param whole  all cases of whole kinds were run   @return the exit code
  int tell(bool whole) const {
    int mended = 0;
    for (const auto& [entry, failed] : failed_of_) {
      if (failed > 0 || !whole) continue;
      ++mended;
      std::fprintf(stderr, "holds now, take it off the list: %s\n", known_text(entry).c_str());
    }
    std::fprintf(stderr, "%d lines, %d do not hold, %d more are known not to\n", lines_, failures_,
                 known_);
    return !judged_ || failures_ + mended == 0 ? 0 : 1;
  }

 private:
  bool judged_;
  int lines_ = 0;
  int failures_ = 0;
  int known_ = 0;
  std::map<int, int> failed_of_;  ///< failed lines, by entry of known.cpp
};

std::vector<Group> groups_of(const std::string& engine) {
  if (engine == "tandem") return all_groups();
  std::string names;
  for (const auto& [name, make] : bench::built_engines()) {
    if (engine == name) return peer_groups(make);
    names += " " + name;
  }
  throw std::invalid_argument("--engine: one of" + names);
}

int run(const Options& options) {
  std::vector<Group> groups = groups_of(options.engine);
  std::erase_if(groups, [&](const Group& group) { return !asked_for(group, options); });
  if (options.list) {
    for (const Group& group : groups) {
      std::printf("%s: %s, %s\n", group.kind.c_str(), group.name.c_str(), group.ground.c_str());
    }
    return 0;
  }
  Table table(options.json);
  const bool judged = options.engine == "tandem";
  Verdict verdict(judged);
  for (const Group& group : groups) {
    const double begin = bench::thread_seconds();
    std::vector<std::string> beyond;
    const Extent extent = options.quick ? Extent::Quick : Extent::Full;
    const std::string title = group.kind + " " + group.name + ", " + group.ground;
    try {
      for (const Line& line : run_group(group, extent, &beyond)) {
        table.line(line, verdict.take(line));
      }
    } catch (const std::invalid_argument& error) {
      if (judged) throw;
      std::fprintf(stderr, "%s: left out: %s\n", title.c_str(), error.what());
    }
    if (!options.cases) beyond.clear();
    for (const std::string& one : beyond) {
      std::fprintf(stderr, "%s: %s\n", title.c_str(), one.c_str());
    }
    const double seconds = bench::thread_seconds() - begin;
    if (seconds > 10.0) std::fprintf(stderr, "%s: %.0f s\n", title.c_str(), seconds);
  }
  return verdict.tell(!options.quick && options.only.empty());
}

}  // namespace
}  // namespace tandem::everyday

int main(int argc, char** argv) {
  using namespace tandem;
  return demos::program_main(argc, argv, everyday::kUsage,
                             [](auto words) { return everyday::run(everyday::parse(words)); });
}
