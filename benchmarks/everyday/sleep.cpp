// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E14: undisturbed bodies fall asleep, and moving ones do not.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"
#include "everyday/piles.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"

namespace tandem::everyday {
namespace {

using Build = std::function<void(AnyWorld&, std::vector<BodyId>&, pbd::SplitMix64&)>;

constexpr int kWindow = 15;        // steps over which poses give a speed
constexpr double kBlow = 0.1;      // m/s: faster is an impact
constexpr double kLate = 6.0;      // s after the last impact
constexpr double kLongest = 30.0;  // s, of a scene with endless impacts

/// Steps until all sleep or are late.
void watch(Tally& tally, AnyWorld& scene, const std::vector<BodyId>& bodies,
           const std::string& which) {
  std::vector<std::vector<Vec3>> places;
  std::vector<bool> was_awake(bodies.size(), true);
  double last_blow = 0.0;
  double moving = 0.0;
  int awake = static_cast<int>(bodies.size());
  for (int k = 0; k * kFrame < kLongest && awake > 0 && (k * kFrame - last_blow) < kLate; ++k) {
    places.emplace_back();
    for (const BodyId body : bodies) places.back().push_back(scene.pose(body).position);
    scene.step(kFrame);
    const std::vector<Vec3>& before =
        places[static_cast<std::size_t>(std::max(0, k + 1 - kWindow))];
    const double window = std::min(k + 1, kWindow) * kFrame;
    awake = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const double speed = (scene.pose(bodies[i]).position - before[i]).norm() / window;
      const bool is_awake = scene.awake(bodies[i]);
      if (is_awake) ++awake;
      if (speed > kBlow) last_blow = (k + 1) * kFrame;
      if (was_awake[i] && !is_awake) moving = std::max(moving, speed);
      was_awake[i] = is_awake;
    }
  }
  tally.failed("awake after 6 s", awake > 0, 0,
               which + ", " + told({{"awake", awake}, {"of", static_cast<double>(bodies.size())}}));
  tally.at_most("speed of what falls asleep", 1e3 * moving, 1.0, "mm/s", which);
}

Quat any_turn(pbd::SplitMix64& random) {
  return pbd::exp_map(
      3.0 * Vec3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
}

template <class Make>
Build rain(int count, double size, Make make) {
  return [=](AnyWorld& scene, std::vector<BodyId>& bodies, pbd::SplitMix64& random) {
    for (int i = 0; i < count; ++i) {
      const Vec3 place(1.3 * size * (i % 3 - 1) + 0.1 * size * random.unit(),
                       1.3 * size * (i / 3 % 3 - 1) + 0.1 * size * random.unit(),
                       size * (1.0 + 1.3 * (i / 9)));
      bodies.push_back(
          scene.add(make(random), {.pose = {.position = place, .orientation = any_turn(random)}}));
    }
  };
}

collision::Shape stone(pbd::SplitMix64& random) {
  std::vector<Vec3> points;
  for (int i = 0; i < 16; ++i) {
    const Vec3 way(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    points.push_back(0.1 * way.normalized().cwiseProduct(Vec3(1.0, 0.8, 0.6)));
  }
  return collision::ConvexHull::make(points);
}

/// @param push  m/s, of the first one
Build dominoes(double push) {
  return [=](AnyWorld& scene, std::vector<BodyId>& bodies, pbd::SplitMix64&) {
    for (int i = 0; i < 40; ++i) {
      SolidDef def{.pose = {.position = Vec3(0.025 * (i - 20), 0.0, 0.025)}};
      if (i == 0)
        def.twist = {.linear = Vec3(push, 0.0, 0.0), .angular = Vec3(0.0, push / 0.025, 0.0)};
      bodies.push_back(scene.add(Box{0.0035, 0.0125, 0.025}, def));
    }
  };
}

void cards(AnyWorld& scene, std::vector<BodyId>& bodies, pbd::SplitMix64&) {
  for (const Pose& pose : house_of_cards()) {
    bodies.push_back(scene.add(Box{kCardHalf}, {.pose = pose, .material = {.friction = 0.6}}));
  }
}

/// Ten upright pins, hit by a ball.
void pins(AnyWorld& scene, std::vector<BodyId>& bodies, pbd::SplitMix64& random) {
  for (int row = 0; row < 4; ++row) {
    for (int i = 0; i <= row; ++i) {
      bodies.push_back(
          scene.add(Cylinder{0.03, 0.19},
                    {.pose = {.position = Vec3(0.26 * row, 0.3 * (i - 0.5 * row), 0.19)}}));
    }
  }
  SolidDef ball{.pose = {.position = Vec3(-1.0, 0.05 * random.unit(), 0.11)},
                .angular_damping = 0.5};
  ball.twist = {.linear = Vec3(5.0, 0.0, 0.0), .angular = Vec3(0.0, 5.0 / 0.11, 0.0)};
  scene.add(Sphere{0.11}, ball);
}

void cans(AnyWorld& scene, std::vector<BodyId>& bodies, pbd::SplitMix64&) {
  for (int row = 0; row < 4; ++row) {
    for (int i = 0; i < 4 - row; ++i) {
      bodies.push_back(
          scene.add(Cylinder{0.033, 0.06},
                    {.pose = {.position = Vec3(0.07 * (i + 0.5 * row), 0.0, 0.06 + 0.12 * row)}}));
    }
  }
}

}  // namespace

std::vector<Group> sleep_groups(const bench::MakeEngine& peer) {
  const auto cube = [](pbd::SplitMix64&) { return collision::Shape(Box{0.1, 0.1, 0.1}); };
  const auto can = [](pbd::SplitMix64&) { return collision::Shape(Cylinder{0.033, 0.06}); };
  const std::vector<std::pair<std::string, Build>> scenes = {
      {"heap of 60 cubes", rain(60, 0.35, cube)},
      {"heap of 200 cubes", rain(200, 0.35, cube)},
      {"heap of 30 stones", rain(30, 0.2, stone)},
      {"heap of 30 cans", rain(30, 0.14, can)},
      {"40 dominoes stand", dominoes(0.0)},
      {"40 dominoes fall", dominoes(0.5)},
      {"house of 40 cards", cards},
      {"ten pins", pins},
      {"pyramid of 10 cans", cans},
  };
  std::vector<Group> groups;
  for (const Ground ground : kGrounds) {
    for (const auto& [name, build] : scenes) {
      groups.push_back({"E14", name, name_of(ground),
                        [=](Tally& tally, Extent extent) {
                          for (int seed = 0; seed < (extent == Extent::Full ? 3 : 1); ++seed) {
                            pbd::SplitMix64 random(static_cast<std::uint64_t>(seed));
                            const auto world = make_world(peer);
                            AnyWorld& scene = *world;
                            add_ground(scene, ground, 0.6, 10.0);
                            std::vector<BodyId> bodies;
                            build(scene, bodies, random);
                            watch(tally, scene, bodies, told({{"seed", seed}}));
                          }
                        },
                        ground == Ground::Box && name != "heap of 200 cubes"});
    }
  }
  return groups;
}

}  // namespace tandem::everyday
