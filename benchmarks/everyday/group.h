// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "demos/engine/engine.h"

/// Small scenes that users of any engine build, each with many sizes, angles, speeds, phases within
/// a step and grounds. The bounds come from physics, at the engine's default setting.
namespace tandem::everyday {

/// The worst case of one measure of a group.
struct Line {
  std::string kind;  ///< E1 to E14
  std::string name;
  std::string ground;
  std::string measure;
  int cases = 0;
  int beyond = 0;      ///< number of cases beyond the bound
  double worst = 0.0;  ///< in the unit
  double bound = 0.0;  ///< of the worst case
  std::string unit;
  std::string worst_case;

  bool holds() const { return worst <= bound; }  // false for NaN
};

/// Collects the measures of a group's cases.
class Tally {
 public:
  /// value <= bound, > 0, in every case; the worst one has the largest value / bound.
  void at_most(const std::string& measure, double value, double bound, const std::string& unit,
               const std::string& which);
  /// At most `allowed` of all cases fail.
  void failed(const std::string& measure, bool failed, int allowed, const std::string& which);

  const std::vector<Line>& lines() const { return lines_; }
  /// Measures beyond their bound, in words.
  const std::vector<std::string>& beyond() const { return beyond_; }

 private:
  Line& line(const std::string& measure, const std::string& unit);

  std::vector<Line> lines_;
  std::vector<std::string> beyond_;
};

/// Number of cases that a group runs.
enum class Extent { Quick, Full };

struct Group {
  std::string kind;
  std::string name;
  std::string ground;
  std::function<void(Tally&, Extent)> run;
  bool quick = false;  ///< has cases for Extent::Quick
};

// Groups for any engine; peer: empty is Tandem.
std::vector<Group> seam_groups(const bench::MakeEngine& peer);    // E1
std::vector<Group> rest_groups(const bench::MakeEngine& peer);    // E2, E3
std::vector<Group> spin_groups(const bench::MakeEngine& peer);    // E4
std::vector<Group> column_groups(const bench::MakeEngine& peer);  // E7
std::vector<Group> fast_groups(const bench::MakeEngine& peer);    // E8
std::vector<Group> sleep_groups(const bench::MakeEngine& peer);   // E14
// Groups for Tandem alone.
std::vector<Group> joint_groups();  // E5
std::vector<Group> stand_groups();  // E9, E10
std::vector<Group> rope_groups();   // E12
/// All of the above, by kind.
std::vector<Group> all_groups();
/// Groups for another engine. A group throws std::invalid_argument if it lacks a shape.
std::vector<Group> peer_groups(const bench::MakeEngine& peer);

std::vector<Line> run_group(const Group& group, Extent extent,
                            std::vector<std::string>* beyond = nullptr);

/// The entry of known.cpp, the only list of exceptions, for a line; -1: it must hold.
int known_entry(const Line& line);
/// Subject and reason of an entry.
std::string known_text(int entry);

}  // namespace tandem::everyday
