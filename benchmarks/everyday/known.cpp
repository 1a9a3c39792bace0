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
constexpr std::string_view kE1 =
    "the edge of the next body is met ahead of time, and turns speed upward";
constexpr std::string_view kE2 =
    "manifolds keep the corners that span most area, whatever their gap; some hulls rock on what "
    "is left";
constexpr std::string_view kE3 =
    "manifolds are clipped against one small triangle of several that bear";
constexpr std::string_view kE4 =
    "the step of free rotation and of contacts is not bounded at a radian a step";
constexpr std::string_view kE5 =
    "the turn nearest to 0 is taken for a hinge's, and what is violated is closed within a step";
constexpr std::string_view kE7 =
    "sweeps are those of the step's start: what is stopped within the step is not seen by the next "
    "one";
constexpr std::string_view kE8 = "the middle is guarded, and no turn is cast";
constexpr std::string_view kE9 =
    "impulses carried from a step are taken for those of one that is far shorter or longer";
constexpr std::string_view kE10 =
    "pushed out of overlaps without friction, feet slide until no friction of 0.6 holds the tops";
constexpr std::string_view kE12 =
    "no geometric stiffness: substeps above 1.5 periods of a segment's swing";
constexpr std::string_view kE14 =
    "what is pushed up and falls down again within a step reports a speed and moves nothing";

// The bounds stay as they are: what does not hold yet stands here, and leaves when it holds.
constexpr Known kKnown[] = {
    {"E1", "sphere slides", "", "", kE1},
    {"E1", "sphere rolls", "", "", kE1},
    {"E1", "ball of 2 cm rolls", "", "", kE1},
    {"E1", "lying capsule slides", "", "", kE1},
    {"E1", "lying capsule rolls", "", "", kE1},
    {"E1", "lying cylinder rolls", "", "", kE1},
    {"E1", "upright cylinder", "two boxes", "", kE1},
    {"E1", "upright cylinder", "two kinematic boxes", "", kE1},
    {"E1", "upright cylinder", "ten boxes", "", kE1},
    {"E1", "cone", "two boxes", "", kE1},
    {"E1", "cone", "two kinematic boxes", "", kE1},
    {"E1", "cone", "two meshes", "stopping distance", kE1},
    {"E1", "cone", "two fields", "stopping distance", kE1},
    {"E1", "cone", "ten boxes", "", kE1},
    {"E1", "box", "two boxes", "speed", kE1},
    {"E1", "box", "two boxes", "hop", kE1},
    {"E1", "box", "two kinematic boxes", "speed", kE1},
    {"E1", "box", "two kinematic boxes", "hop", kE1},
    {"E1", "box", "ten boxes", "speed", kE1},
    {"E1", "box", "ten boxes", "hop", kE1},
    {"E1", "hull of a box", "two boxes", "", kE1},
    {"E1", "hull of a box", "two kinematic boxes", "", kE1},
    {"E1", "hull of a box", "ten boxes", "", kE1},
    {"E1", "compound of two boxes", "two boxes", "speed", kE1},
    {"E1", "compound of two boxes", "two boxes", "hop", kE1},
    {"E1", "compound of two boxes", "two kinematic boxes", "speed", kE1},
    {"E1", "compound of two boxes", "two kinematic boxes", "hop", kE1},
    {"E1", "compound of two boxes", "ten boxes", "", kE1},
    {"E2", "hulls of random points", "half-space", "", kE2},
    {"E2", "hulls of random points", "box", "", kE2},
    {"E2", "hulls of random points", "mesh", "awake", kE2},
    {"E2", "hulls of random points", "mesh", "spin, sleep off", kE2},
    {"E2", "hulls of random points", "field", "", kE2},
    {"E2", "hulls of random points", "hull", "", kE2},
    {"E3", "bumpy cubes", "", "", kE3},
    {"E3", "scanned tins and parcels", "", "", kE3},
    {"E4", "rods and pencils roll", "", "", kE4},
    {"E4", "thrown rods", "", "", kE4},
    {"E4", "rollers dropped at 200 rad/s", "", "", kE4},
    {"E4", "dowel rolls at 1 m/s", "", "", kE4},
    {"E4", "rod in free precession", "", "", kE4},
    {"E7", "column of 12 cubes of 16 mm", "", "", kE7},
    {"E7", "column of 12 cubes of 30 mm", "", "", kE7},
    {"E7", "column of 12 cubes of 50 mm", "box", "overlap", kE7},
    {"E7", "column of 12 balls of 16 mm", "", "", kE7},
    {"E7", "column of 12 balls of 30 mm", "", "", kE7},
    {"E7", "column of 12 balls of 50 mm", "box", "overlap", kE7},
    {"E7", "column of 12 cylinders of 16 mm", "", "", kE7},
    {"E7", "column of 12 cylinders of 30 mm", "", "", kE7},
    {"E7", "column of 12 cylinders of 50 mm", "box", "overlap", kE7},
    {"E8", "bat at 60 rad/s", "", "", kE8},
    {"E8", "bat at 120 rad/s", "", "", kE8},
    {"E9", "stack of 8, two steps in turn", "", "", kE9},
    {"E9", "stack of 8, steps of 1e-12 to 0.2 s", "", "", kE9},
    {"E10", "house of 40 cards of 1 cm", "", "", kE10},
    {"E12", "10 kg swing on a rope of 1 kg", "", "", kE12},
    {"E12", "100 kg swing on a rope of 1 kg", "", "", kE12},
    {"E12", "1000 kg swing on a rope of 1 kg", "", "", kE12},
    {"E14", "heap of 60 cubes", "half-space", "speed of what falls asleep", kE14},
    {"E14", "heap of 60 cubes", "box", "speed of what falls asleep", kE14},
    {"E14", "heap of 60 cubes", "mesh", "awake after 6 s", kE14},
    {"E14", "heap of 60 cubes", "field", "awake after 6 s", kE14},
    {"E14", "heap of 60 cubes", "hull", "", kE14},
    {"E14", "heap of 200 cubes", "half-space", "speed of what falls asleep", kE14},
    {"E14", "heap of 200 cubes", "box", "", kE14},
    {"E14", "heap of 200 cubes", "mesh", "", kE14},
    {"E14", "heap of 200 cubes", "field", "", kE14},
    {"E14", "heap of 200 cubes", "hull", "awake after 6 s", kE14},
    {"E14", "heap of 30 stones", "half-space", "awake after 6 s", kE14},
    {"E14", "heap of 30 stones", "box", "awake after 6 s", kE14},
    {"E14", "heap of 30 stones", "mesh", "awake after 6 s", kE14},
    {"E14", "heap of 30 stones", "hull", "awake after 6 s", kE14},
    {"E14", "heap of 30 cans", "half-space", "awake after 6 s", kE14},
    {"E14", "heap of 30 cans", "box", "awake after 6 s", kE14},
    {"E14", "heap of 30 cans", "mesh", "awake after 6 s", kE14},
    {"E14", "heap of 30 cans", "field", "awake after 6 s", kE14},
    {"E14", "heap of 30 cans", "hull", "awake after 6 s", kE14},
    {"E14", "ten pins", "half-space", "awake after 6 s", kE14},
    {"E14", "ten pins", "box", "awake after 6 s", kE14},
    {"E14", "ten pins", "mesh", "awake after 6 s", kE14},
    {"E14", "ten pins", "field", "awake after 6 s", kE14},
    {"E14", "ten pins", "hull", "awake after 6 s", kE14},
    {"E5", "hinges beyond half a turn", "", "", kE5},
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
