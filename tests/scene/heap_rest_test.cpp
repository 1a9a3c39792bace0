// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is thrown on a heap or built into a tower comes to rest.
#include <catch2/catch.hpp>
#include <cmath>
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

TEST_CASE("scene: towers that nobody has built exactly stand still and sleep",
          "[scene][property]") {
  pbd::SplitMix64 random(92);
  for (int run = 0; run < 24; ++run) {
    Scene scene;
    scene.add(HalfSpace{}, {.type = BodyType::Static, .material = {.friction = 0.6}});
    const double edge = std::exp(random.uniform(std::log(0.05), std::log(2.0)));  // m
    const int count = 3 + static_cast<int>(random.uniform(0.0, 7.9));
    const double offset = random.uniform(0.0, 0.05) * edge;
    const double step = run % 2 == 0 ? kStep : 0.5 * kStep;
    std::vector<BodyId> cubes;
    for (int i = 0; i < count; ++i) {
      const Vec3 place(offset * random.uniform(-1.0, 1.0), offset * random.uniform(-1.0, 1.0),
                       (0.5 + i) * edge);
      cubes.push_back(scene.add(Box{Vec3::Constant(0.5 * edge)},
                                {.pose = {.position = place}, .material = {.friction = 0.6}}));
    }
    const Vec3 top = scene.pose(cubes.back()).position;
    const BodyId middle = cubes[cubes.size() / 2];
    const double touch = random.uniform(0.0, 0.05) * std::sqrt(9.81 * edge);  // m/s
    for (double time = 0.0; time < 6.5; time += step) {
      if (time < 0.5 && time + step >= 0.5) {
        const double mass = scene.world().props(middle).mass;
        scene.world().apply_impulse(middle, Vec3(mass * touch, 0.0, 0.0));
      }
      scene.step(step);
    }
    INFO("run " << run << ": " << count << " cubes of " << edge << " m, off by " << offset);
    CHECK_FALSE(scene.world().awake(cubes.back()));
    CHECK((scene.pose(cubes.back()).position - top).norm() < 0.01 * edge);
  }
}

}  // namespace tandem::heap_rest_test
