// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstddef>
#include <iterator>

#include "everyday/group.h"

namespace tandem::everyday {
namespace {

struct Known {
  std::string_view kind;
  std::string_view name;     ///< of the group; empty: all of the kind
  std::string_view ground;   ///< empty: all
  std::string_view measure;  ///< empty: all
  std::string_view reason;
};

// Reasons, by kind.
constexpr std::string_view kE2 = "some rock from edge to edge for longer than that";
constexpr std::string_view kE10 =
    "plates that begin 10 mm inside each other are pushed apart; the house stands that at no speed "
    "from 4 m/s to 1 cm/s, and with 5 mm of overlap left alone four of ten do";
constexpr std::string_view kRocks =
    "in one or two heaps of 100 a cube rocks on between two supports that lie close together";
constexpr std::string_view kWay =
    "of 0.5 mm in half a second nearly all may lie in half of it: up to 1.8 mm/s there";
constexpr std::string_view kRolls =
    "some roll on at 0.3 to 0.7 m/s, as E4 asks of a dowel: there is no rolling resistance";

// Lines that do not hold yet; remove an entry once its lines hold.
constexpr Known kKnown[] = {
    {"E2", "hulls of random points", "", "", kE2},
    {"E10", "house of 40 cards of 1 cm", "", "", kE10},
    {"E14", "heap of 60 cubes", "", "awake after 6 s", kRocks},
    {"E14", "heap of 200 cubes", "", "speed of what falls asleep", kWay},
    {"E14", "heap of 30 cans", "", "awake after 6 s", kRolls},
    {"E14", "ten pins", "", "awake after 6 s", kRolls},
};

bool fits(std::string_view pattern, std::string_view text) {
  return pattern.empty() || pattern == text;
}

}  // namespace

int known_entry(const Line& line) {
  for (std::size_t i = 0; i < std::size(kKnown); ++i) {
    const Known& known = kKnown[i];
    if (known.kind == line.kind && fits(known.name, line.name) && fits(known.ground, line.ground) &&
        fits(known.measure, line.measure)) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

std::string known_text(int entry) {
  const Known& known = kKnown[static_cast<std::size_t>(entry)];
  std::string text(known.kind);
  for (const std::string_view part : {known.name, known.ground, known.measure, known.reason}) {
    if (!part.empty()) text += ", " + std::string(part);
  }
  return text;
}

}  // namespace tandem::everyday
