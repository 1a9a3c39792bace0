// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "numerics/case.h"

namespace tandem::bench {
namespace {

struct Known {
  std::string_view name;     ///< of the case
  std::string_view measure;  ///< of the line; empty: all lines of the case
  std::string_view reason;
};

// The bounds stay as they are: what does not hold yet stands here, and leaves when it holds.
constexpr std::string_view kWhip = "goes slack and whips, which the substeps do not resolve";
constexpr std::string_view kSpin = "turning by w h is of first order in the torque";
constexpr std::string_view kPile =
    "the contacts' multipliers do not converge at the default setting";
constexpr std::string_view kBullet = "contacts are found once for each step";
constexpr Known kKnown[] = {
    {"Dzhanibekov flip, 20 rad/s", "angular momentum drift", kSpin},
    {"heavy top, 20 rad/s", "", kSpin},
    {"Newton's cradle", "", "contacts are solved together, so the middle balls share the blow"},
    {"chain of 20, end 100 links, dropped", "", kWhip},
    {"chain of 50, end 1 link, dropped", "", kWhip},
    {"chain of 50, end 1000 links, dropped", "", kWhip},
    {"masses 1 to 10000 kg, light below", "top error", kPile},
    {"pyramid of base 15", "drift", kPile},
    {"pyramid of base 30", "drift", kPile},
    {"free spin, 1e4 rad/s", "energy growth", "turns by 17 rad in a substep"},
    {"ball of 10 cm, 1000 m/s, wall of 1 cm", "", kBullet},
    {"cube of 10 cm, 1000 m/s, wall of 1 cm", "", kBullet},
    {"ball of 1 cm, 1000 m/s, wall of 1 cm", "", kBullet},
    {"1 mm and 100 m in one scene", "drift of a small cube", kPile},
    {"bad input", "mesh with a corner at NaN", "the message says where, not what"},
};

}  // namespace

std::string_view known_failure(const std::string& name, const std::string& measure) {
  for (const Known& known : kKnown) {
    if (known.name == name && (known.measure.empty() || known.measure == measure)) {
      return known.reason;
    }
  }
  return {};
}

std::vector<std::string_view> known_cases() {
  std::vector<std::string_view> names;
  for (const Known& known : kKnown) names.push_back(known.name);
  return names;
}

}  // namespace tandem::bench
