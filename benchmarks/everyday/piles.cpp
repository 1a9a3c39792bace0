// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "everyday/piles.h"

#include <cmath>
#include <numbers>

#include "tandem/pbd/math.h"

namespace tandem::everyday {

std::vector<Pose> house_of_cards() {
  const double lean = 25.0 * std::numbers::pi / 180.0;
  const auto turned = [](double angle) { return pbd::exp_map(Vec3(0.0, angle, 0.0)); };
  std::vector<Pose> cards;
  double from = 0.0;
  double z = kCardHalf.z() - 0.02;
  for (int storey = 5; storey > 0; --storey) {
    double x = from;
    for (int i = 0; i < storey; ++i) {
      if (i + 1 < storey) {
        cards.push_back({.position = Vec3(x + 0.25, 0.0, z + kCardHalf.z() - 0.015),
                         .orientation = turned(std::numbers::pi / 2.0)});
      }
      cards.push_back({.position = Vec3(x, 0.0, z), .orientation = turned(lean)});
      cards.push_back({.position = Vec3(x + 0.175, 0.0, z), .orientation = turned(-lean)});
      x += 0.35;
    }
    z += 2.0 * kCardHalf.z() - 0.03;
    from += 0.175;
  }
  return cards;
}

}  // namespace tandem::everyday
