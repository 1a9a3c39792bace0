// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E9: a stack stands with any step length. E10: a house of cards that start overlapping stands.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "everyday/ground.h"
#include "everyday/group.h"
#include "everyday/piles.h"
#include "tandem/pbd/random.h"

namespace tandem::everyday {
namespace {

/// Eight cubes, flush on each other.
void stack(Tally& tally, double size, const std::string& which,
           const std::function<double(int)>& dt) {
  Scene scene;
  add_ground(scene, Ground::Box, 0.5, 20.0);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 8; ++i) {
    bodies.push_back(scene.add(Box{Vec3::Constant(0.5 * size)},
                               {.pose = {.position = Vec3(0.0, 0.0, size * (0.5 + i))}}));
  }
  double off = 0.0;
  for (int k = 0; k < 600; ++k) {
    scene.step(dt(k));
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const double moved =
          (scene.pose(bodies[i]).position - Vec3(0.0, 0.0, size * (0.5 + static_cast<double>(i))))
              .norm();
      off = std::isfinite(moved) ? std::max(off, moved) : HUGE_VAL;
    }
  }
  tally.at_most("moved", 100.0 * off / size, 5.0, "% of an edge", which);
}

void alternating(Tally& tally, Extent extent) {
  for (const double size : extent == Extent::Full ? std::vector{0.1, 0.5, 1.0} : std::vector{0.5}) {
    for (const double other : {1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.05, 0.1, 0.2}) {
      stack(tally, size, told({{"size", size}, {"other step", other}}),
            [&](int k) { return k % 2 == 0 ? kFrame : other; });
    }
  }
}

void random_steps(Tally& tally, Extent extent) {
  for (int seed = 0; seed < (extent == Extent::Full ? 10 : 2); ++seed) {
    for (const double size : {0.1, 0.5, 1.0}) {
      pbd::SplitMix64 random(static_cast<std::uint64_t>(seed));
      stack(tally, size, told({{"size", size}, {"seed", seed}}),
            [&](int) { return std::pow(10.0, random.uniform(-12.0, std::log10(0.2))); });
    }
  }
}

/// In listed and in shuffled order.
void house(Tally& tally, Extent extent) {
  const std::vector<Pose> cards = house_of_cards();
  for (int order = 0; order < (extent == Extent::Full ? 10 : 1); ++order) {
    std::vector<std::size_t> turn(cards.size());
    std::iota(turn.begin(), turn.end(), std::size_t{0});
    pbd::SplitMix64 random(static_cast<std::uint64_t>(order));
    for (std::size_t i = turn.size() - 1; order > 0 && i > 0; --i) {
      std::swap(turn[i], turn[random.below(i + 1)]);
    }
    Scene scene;
    add_ground(scene, Ground::Box, 0.6, 50.0);
    std::vector<BodyId> bodies;
    for (const std::size_t i : turn) {
      bodies.push_back(
          scene.add(Box{kCardHalf}, {.pose = cards[i], .material = {.friction = 0.6}}));
    }
    for (int i = 0; i < 600; ++i) scene.step(kFrame);
    double drift = 0.0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Vec3 moved = scene.pose(bodies[i]).position - cards[turn[i]].position;
      drift = std::max(drift, std::hypot(moved.x(), moved.y()));
    }
    tally.at_most("drift", 1e3 * drift, 10.0, "mm", told({{"order", order}}));
  }
}

}  // namespace

std::vector<Group> stand_groups() {
  return {{"E9", "stack of 8, two steps in turn", "box", alternating, true},
          {"E9", "stack of 8, steps of 1e-12 to 0.2 s", "box", random_steps, true},
          {"E10", "house of 40 cards of 1 cm", "box", house, true}};
}

}  // namespace tandem::everyday
