// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/story.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <vector>

#include "arguments/terminal.h"
#include "scenes/words.h"

namespace tandem::demos {

namespace {

constexpr std::size_t kColumns = 80;

/// Terminal escapes, or none.
class Ink {
 public:
  explicit Ink(bool on) : on_(on) {}
  std::string bold(const std::string& text) const { return with("1", text); }
  std::string faint(const std::string& text) const { return with("2", text); }
  std::string verdict(bool good, const std::string& text) const {
    return with(good ? "32" : "31", text);
  }

 private:
  std::string with(const char* code, const std::string& text) const {
    return on_ ? "\033[" + std::string(code) + 'm' + text + "\033[0m" : text;
  }

  bool on_;
};

/// Wrapped to the terminal's width, with a final newline.
std::string wrapped(std::string_view text) {
  std::string lines;
  while (text.size() > kColumns) {
    std::size_t end = text.rfind(' ', kColumns);
    if (end == std::string_view::npos) end = std::min(text.find(' '), text.size());
    (lines += text.substr(0, end)) += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return (lines += text) += '\n';
}

std::string capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string name_of(Scheme scheme) {
  if (scheme == Scheme::OnePass) return "with agreement";
  if (scheme == Scheme::None) return "without agreement";
  if (scheme == Scheme::SingleOwner) return "with a single owner";
  return "with " + std::string(to_string(scheme));
}

/// Why the coupling cannot do better with any settings; empty if unknown.
std::string_view why(Scheme scheme) {
  if (scheme == Scheme::None) {
    return "Without agreement every computer simulates alone. What differs by a hair's breadth at "
           "first grows with every contact, and nothing brings the copies together again.";
  }
  if (scheme == Scheme::SingleOwner) {
    return "A single owner loses by its nature: only the owner's computer moves a thing, so what "
           "somebody else does to it does not count until it has been handed over, a round trip "
           "later, and two people never pull at once. Between the owner's messages the other "
           "copies run on as they last moved, into floors and tables.";
  }
  return {};
}

/// "Two people and one who watches, 28.5 ms apart,"
std::string who(const Scenario& scenario, const Report& report) {
  const DemoOptions& o = report.options;
  const std::size_t peers = report.run.peers.size();
  const std::size_t people = o.no_script ? 0 : scenario.user_count();
  std::string text =
      people == 0 ? count_words(peers, "peer") : count_words(people, "person", "people");
  if (people > 0 && peers > people) {
    text += " and " + count_words(peers - people, "other who watches", "others who watch");
  }
  if (peers < 2) return text + " at one computer";
  if (o.over_network()) {
    if (report.metrics.latency_ms.count == 0) return text;
    return text + ", whose news were " + two_digits(report.metrics.latency_ms.mean) +
           " ms old when they were used,";
  }
  const double latency = o.link_options().latency;  // s, one way
  if (latency <= 0.0) return text + ", with no delay between them,";
  std::array<char, 32> milliseconds{};
  std::snprintf(milliseconds.data(), milliseconds.size(), ", %.4g ms apart,", 1e3 * latency);
  return text + milliseconds.data();
}

/// Divergence of unowned bodies if there are any, else of all.
const Distribution& apart(const Metrics& metrics) {
  return metrics.shared_m.count > 0 ? metrics.shared_m : metrics.divergence_m;
}

/// "5.6 mm, 2.9 degrees" @param metres, degrees  distance and angle between copies
std::string gap(double metres, double degrees) {
  std::string text = length_words(metres);
  return degrees >= 0.01 ? text + ", " + two_digits(degrees) + " degrees" : text;
}

std::string copies(const Report& report) {
  if (report.run.peers.size() < 2) return "There was one copy, and nothing to agree upon.";
  const Distribution& d = apart(report.metrics);
  if (d.count == 0) return "They did not hear of each other.";
  return "Their copies were typically " + length_words(d.p50) + " and at most " +
         length_words(d.max) + " apart.";
}

/// The achievements of each local peer.
std::vector<Achievement> achievements(const Scenario& scenario, const Report& report) {
  std::vector<Achievement> all;
  for (const PeerRecord& peer : report.run.peers) {
    if (!peer.outcome.empty()) all.push_back(scenario.achievement(peer.outcome));
  }
  return all;
}

/// The figure, or one per peer if they differ.
std::string figures(const std::vector<Achievement>& all) {
  std::vector<std::string> each;
  for (const Achievement& one : all) {
    if (std::find(each.begin(), each.end(), one.figure) == each.end()) each.push_back(one.figure);
  }
  std::string text;
  for (const std::string& figure : each) text += (text.empty() ? "" : " or ") + figure;
  return text;
}

bool done(const std::vector<Achievement>& all) {
  return std::all_of(all.begin(), all.end(), [](const Achievement& one) { return one.done; });
}

struct Row {
  std::string name;
  std::array<std::string, 2> cells;
  /// True for good cells; none if neither direction is better.
  std::optional<std::array<bool, 2>> good = std::nullopt;
};

std::vector<Row> rows(const Scenario& scenario, const Report& report, const Report& other) {
  std::vector<Row> table{{"", {name_of(report.options.scheme), name_of(other.options.scheme)}}};
  const auto first = achievements(scenario, report);
  const auto second = achievements(scenario, other);
  if (!first.empty() && !second.empty()) {
    table.push_back(
        {first[0].name, {figures(first), figures(second)}, {{done(first), done(second)}}});
  }
  const auto add = [&](const char* name, double Distribution::*part) {
    const auto cell = [part](const Metrics& m) {
      return gap(apart(m).*part, m.divergence_deg.*part);
    };
    table.push_back({name, {cell(report.metrics), cell(other.metrics)}});
  };
  if (apart(report.metrics).count > 0 && apart(other.metrics).count > 0) {
    add("copies typically apart", &Distribution::p50);
    add("  19 of 20 times within", &Distribution::p95);
    add("  at most", &Distribution::max);
  }
  if (!report.stable() || !other.stable()) {
    const auto fault = [](const Report& r) { return r.stable() ? "nothing" : r.fault; };
    table.push_back(
        {"went wrong", {fault(report), fault(other)}, {{report.stable(), other.stable()}}});
  }
  return table;
}

std::string side_by_side(const std::vector<Row>& table, const Ink& ink) {
  std::size_t name = 0, cell = 0;
  for (const Row& row : table) {
    name = std::max(name, row.name.size());
    cell = std::max(cell, row.cells[0].size());
  }
  std::string text;
  for (const Row& row : table) {
    const auto shown = [&](std::size_t i) {
      const std::string padding(i == 0 ? cell - row.cells[0].size() : 0, ' ');
      if (&row == &table.front()) return ink.bold(row.cells[i]) + padding;
      return (row.good ? ink.verdict((*row.good)[i], row.cells[i]) : row.cells[i]) + padding;
    };
    const std::string padding(name - row.name.size(), ' ');
    text += "  " + row.name + padding + "   " + shown(0) + "   " + shown(1) + '\n';
  }
  return text;
}

}  // namespace

bool may_colour(std::FILE* file) {
  const char* const forbidden = std::getenv("NO_COLOR");
  return (forbidden == nullptr || *forbidden == '\0') && is_terminal(file);
}

std::string story(const Scenario& scenario, const Report& report, const Report* beside,
                  bool colour) {
  const Ink ink(colour);
  const auto achieved = achievements(scenario, report);
  const std::string deed = achieved.empty() ? "shared one scene" : achieved.front().text;
  std::string text =
      ink.bold(wrapped(capital(who(scenario, report)) + ' ' + deed + ". " + copies(report)));
  if (!report.stable()) text += ink.verdict(false, wrapped("It went wrong: " + report.fault + "."));
  if (beside != nullptr) {
    text += '\n' + side_by_side(rows(scenario, report, *beside), ink);
    const std::string_view reason = why(beside->options.scheme);
    if (!reason.empty() && done(achieved)) text += '\n' + wrapped(reason);
  }
  return text + '\n' +
         ink.faint(
             "--view shows it in a browser, --print details all measures, --help what else there "
             "is.") +
         '\n';
}

}  // namespace tandem::demos
