// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "everyday/group.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace tandem::everyday {
namespace {

void append(std::vector<Group>& all, std::vector<Group> groups) {
  all.insert(all.end(), std::make_move_iterator(groups.begin()),
             std::make_move_iterator(groups.end()));
}

}  // namespace

Line& Tally::line(const std::string& measure, const std::string& unit) {
  for (Line& line : lines_) {
    if (line.measure == measure) return line;
  }
  lines_.push_back({.measure = measure, .unit = unit});
  return lines_.back();
}

void Tally::at_most(const std::string& measure, double value, double bound, const std::string& unit,
                    const std::string& which) {
  if (std::isnan(value)) value = HUGE_VAL;
  Line& line = this->line(measure, unit);
  const bool first = line.cases == 0;
  ++line.cases;
  if (first || value * line.bound > line.worst * bound) {
    line.worst = value;
    line.bound = bound;
    line.worst_case = which;
  }
  if (value <= bound) return;
  ++line.beyond;
  beyond_.push_back(which + ": " + measure + " " + std::to_string(value) + " " + unit + ", bound " +
                    std::to_string(bound));
}

void Tally::failed(const std::string& measure, bool failed, int allowed, const std::string& which) {
  Line& line = this->line(measure, "cases");
  ++line.cases;
  line.bound = allowed;
  if (!failed) return;
  ++line.beyond;
  line.worst += 1.0;
  line.worst_case = which;
  beyond_.push_back(which + ": " + measure);
}

std::vector<Group> all_groups() {
  std::vector<Group> all = peer_groups({});
  for (const auto part : {joint_groups, stand_groups, rope_groups}) append(all, part());
  std::stable_sort(all.begin(), all.end(), [](const Group& a, const Group& b) {
    return std::stoi(a.kind.substr(1)) < std::stoi(b.kind.substr(1));
  });
  return all;
}

std::vector<Group> peer_groups(const bench::MakeEngine& peer) {
  std::vector<Group> all;
  for (const auto part :
       {seam_groups, rest_groups, spin_groups, column_groups, fast_groups, sleep_groups}) {
    append(all, part(peer));
  }
  return all;
}

std::vector<Line> run_group(const Group& group, Extent extent, std::vector<std::string>* beyond) {
  Tally tally;
  group.run(tally, extent);
  if (beyond != nullptr) *beyond = tally.beyond();
  std::vector<Line> lines = tally.lines();
  for (Line& line : lines) {
    line.kind = group.kind;
    line.name = group.name;
    line.ground = group.ground;
  }
  return lines;
}

}  // namespace tandem::everyday
