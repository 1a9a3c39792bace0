// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <random>
#include <vector>

#include "support/catch.h"
#include "tandem/scene.h"

namespace step_length_test {

using namespace tandem;

constexpr double kStep = 1.0 / 60.0;

TEST_CASE("scene: steps too short to be made are gathered, and no time is lost", "[scene]") {
  std::mt19937 random(12);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };
  Scene scene;
  scene.add(Sphere{0.1});
  double time = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double dt = 1e-12 * std::pow(1e8, number());  // s, up to 1e-4
    const auto hash = scene.world().hash();
    if (scene.step(dt).status == pbd::StepStatus::InvalidStep) {
      REQUIRE(scene.world().hash() == hash);
    }
    time += dt;
    REQUIRE(scene.world().time() <= time + 1e-12);
    REQUIRE(scene.world().time() > time - pbd::kShortestStep - 1e-12);
  }
}

TEST_CASE("scene: a stack of eight stands under steps of any length in any order",
          "[scene][property][long]") {
  std::mt19937 random(13);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  constexpr double kHalf = 0.1;  // m
  for (int run = 0; run < 40; ++run) {
    Scene scene({.solver = {.sleep_after = 0.0}});
    scene.add(HalfSpace{}, {.type = BodyType::Static});
    std::vector<Vec3> places;
    std::vector<BodyId> boxes;
    for (int i = 0; i < 8; ++i) {
      const Vec3 at(number(-0.01, 0.01), number(-0.01, 0.01), kHalf + 2.0 * kHalf * i);
      places.push_back(at);
      boxes.push_back(scene.add(Box{kHalf, kHalf, kHalf}, {.pose = {.position = at}}));
    }
    // A frame and what is left of one in turn, or anything.
    const double rest = std::exp(number(std::log(1e-12), std::log(1e-3)));
    double time = 0.0;
    for (int i = 0; time < 3.0; ++i) {
      const double frame = i % 2 == 0 ? kStep : rest;
      const double dt = run % 2 == 0 ? frame : std::exp(number(std::log(1e-12), std::log(0.2)));
      scene.step(dt);
      time += dt;
    }
    INFO("run " << run << ", rest " << rest);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      CHECK((scene.world().pose(boxes[i]).position - places[i]).norm() < 0.1 * 2.0 * kHalf);
    }
  }
}

}  // namespace step_length_test
