// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is thrown on a heap comes to rest: nothing creeps on.
#include <catch2/catch.hpp>
#include <vector>

#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"
#include "tandem/scene.h"

namespace tandem::heap_rest_test {
namespace {

constexpr double kStep = 1.0 / 60.0;  // s

/// Boxes that fall in layers of nine, turned at random.
std::vector<BodyId> rain(Scene& scene, pbd::SplitMix64& random, int count) {
  std::vector<BodyId> bodies;
  const double size = random.uniform(0.1, 0.5);  // m
  const auto some = [&] { return random.uniform(-1.0, 1.0); };
  for (int i = 0; i < count; ++i) {
    const Vec3 place(0.45 * (i % 3 - 1), 0.45 * (i / 3 % 3 - 1), 0.4 + 0.45 * (i / 9));
    const Vec3 edges(0.6, random.uniform(0.4, 0.6), random.uniform(0.3, 0.6));
    bodies.push_back(
        scene.add(Box{Vec3(0.5 * size * edges)},
                  {.pose = {.position = size / 0.35 * place + 0.05 * size * Vec3(some(), some(), 0),
                            .orientation = pbd::exp_map(3.0 * Vec3(some(), some(), some()))},
                   .material = {.friction = 0.6}}));
  }
  return bodies;
}

}  // namespace

TEST_CASE("scene: in a heap of boxes nothing creeps on", "[scene][property][long]") {
  pbd::SplitMix64 random(91);
  for (int run = 0; run < 8; ++run) {
    Scene scene({.solver = {.sleep_after = 0.0}});
    scene.add(HalfSpace{}, {.type = BodyType::Static, .material = {.friction = 0.6}});
    const std::vector<BodyId> bodies = rain(scene, random, run % 2 == 0 ? 60 : 150);
    for (int k = 0; k < 480; ++k) scene.step(kStep);
    std::vector<Vec3> before;
    for (const BodyId id : bodies) before.push_back(scene.pose(id).position);
    for (int k = 0; k < 60; ++k) scene.step(kStep);
    int creep = 0;  // by more than 1 mm/s
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if ((scene.pose(bodies[i]).position - before[i]).norm() > 1e-3) ++creep;
    }
    INFO("run " << run << " of " << bodies.size());
    CHECK(creep <= 1);  // one may still roll over
  }
}

}  // namespace tandem::heap_rest_test
