// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What stands still is not looked at, and is there as soon as something comes to it.
#include <algorithm>
#include <vector>

#include "support/catch.h"
#include "tandem/pbd/world_copy.h"
#include "tandem/scene.h"

namespace still_test {

using namespace tandem;

namespace {

constexpr double kStep = 1.0 / 60.0;
constexpr int kSide = 20;

/// Flush tiles whose upper faces are at 0.
std::vector<BodyId> add_floor(Scene& scene) {
  std::vector<BodyId> tiles;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec3 at(i % kSide, i / kSide, -0.5);
    tiles.push_back(
        scene.add(Box{{0.5, 0.5, 0.5}}, {.type = BodyType::Static, .pose = {.position = at}}));
  }
  return tiles;
}

BodyId add_cube(Scene& scene, const Vec3& at) {
  return scene.add(Box{{0.3, 0.3, 0.3}}, {.pose = {.position = at}});
}

void run(Scene& scene, int steps) {
  for (int i = 0; i < steps; ++i) scene.step(kStep);
}

std::size_t looked_at(const Scene& scene) { return scene.shapes().stats().looked_at; }

bool ran_nothing(const pbd::StepReport& report) {
  return std::none_of(report.ran.begin(), report.ran.end(), [](bool ran) { return ran; });
}

/// Until nothing runs any more.
int steps_to_rest(Scene& scene) {
  int steps = 0;
  while (steps < 600 && !ran_nothing(scene.step(kStep))) ++steps;
  return steps;
}

TEST_CASE("A step looks at static bodies where they have changed, and at no other", "[scene]") {
  Scene scene;
  const std::vector<BodyId> tiles = add_floor(scene);
  const BodyId cube = add_cube(scene, {5.2, 5.3, 3.0});
  run(scene, 3);
  CHECK(looked_at(scene) == 1);
  scene.set_pose(tiles[0], {.position = {0.0, 0.0, -1.5}});
  scene.step(kStep);
  CHECK(looked_at(scene) == 2);
  const BodyId more = scene.add(Box{{0.5, 0.5, 0.5}},
                                {.type = BodyType::Static, .pose = {.position = {5.0, 5.0, -2.0}}});
  run(scene, 3);
  CHECK(looked_at(scene) == 1);
  // A tile that goes up is a step higher at once, one that is gone holds nothing.
  run(scene, 120);
  CHECK(scene.pose(cube).position.z() == Approx(0.3).margin(1e-3));
  for (const int i : {5, 6}) {
    for (const int k : {5, 6}) scene.remove(tiles[static_cast<std::size_t>(i + kSide * k)]);
  }
  scene.remove(more);
  run(scene, 60);
  CHECK(scene.pose(cube).position.z() < -2.0);
}

TEST_CASE("A static body that becomes dynamic falls, and one that becomes static holds",
          "[scene]") {
  Scene scene;
  const std::vector<BodyId> tiles = add_floor(scene);
  const BodyId cube = add_cube(scene, {0.0, 0.0, 0.3});
  run(scene, 60);
  scene.world().set_mass(tiles[0], 100.0, 20.0 * pbd::Mat3::Identity());
  run(scene, 30);
  CHECK(looked_at(scene) == 2);
  CHECK(scene.pose(tiles[0]).position.z() < -1.0);
  CHECK(scene.pose(cube).position.z() < 0.0);
  scene.world().set_type(tiles[0], BodyType::Static);
  const double height = scene.pose(tiles[0]).position.z();
  run(scene, 120);
  CHECK(scene.pose(tiles[0]).position.z() == height);
  CHECK(scene.pose(cube).position.z() == Approx(height + 0.8).margin(1e-3));
}

TEST_CASE("A world that rests counts time and nothing else", "[scene]") {
  Scene scene;
  add_floor(scene);
  const BodyId cube = add_cube(scene, {5.2, 5.3, 0.3});
  const BodyId other = add_cube(scene, {9.2, 9.3, 0.3});
  REQUIRE(steps_to_rest(scene) < 120);
  const std::uint64_t hash = scene.world().hash();
  const double time = scene.world().time();
  const pbd::StepReport report = scene.step(kStep);
  CHECK(ran_nothing(report));
  CHECK(report.bodies == kSide * kSide + 2);
  CHECK(report.awake == 0);
  CHECK(scene.world().hash() == hash);
  CHECK(scene.world().time() == time + kStep);
  scene.world().apply_force(cube, {0.0, 0.0, 1e5});
  CHECK(scene.step(kStep).awake == 1);
  CHECK(scene.pose(cube).position.z() > 0.3);
  CHECK(scene.pose(other).position.z() == Approx(0.3).margin(1e-3));
}

TEST_CASE("Whatever is done to a world that rests is seen in the next step", "[scene]") {
  Scene scene;
  const std::vector<BodyId> tiles = add_floor(scene);
  const BodyId cube = add_cube(scene, {5.0, 5.0, 0.3});
  const BodyId slider = scene.add(
      Box{{0.1, 0.1, 0.1}}, {.type = BodyType::Kinematic, .pose = {.position = {0.0, 0.0, 5.0}}});
  REQUIRE(steps_to_rest(scene) < 120);
  const std::size_t under = 5 + 5 * kSide;
  SECTION("its floor goes") { scene.remove(tiles[under]); }
  SECTION("gravity") { scene.world().set_gravity({0.0, 0.0, -5.0}); }
  SECTION("a new body") { add_cube(scene, {8.0, 8.0, 2.0}); }
  SECTION("a kinematic body is sent away") {
    scene.world().set_kinematic_target(slider, {.position = {0.0, 0.0, 6.0}});
  }
  SECTION("a kinematic body goes") { scene.world().set_twist(slider, {.linear = {0.0, 0.0, 1.0}}); }
  SECTION("a material") {
    const collision::ColliderId id = scene.shapes().collider_at(static_cast<std::uint32_t>(under));
    scene.shapes().set_material(id, {.friction = 0.1});
  }
  SECTION("a filter") {
    const collision::ColliderId id = scene.shapes().collider_at(static_cast<std::uint32_t>(under));
    scene.shapes().set_filter(id, {.mask = 0});
  }
  SECTION("another length") {
    CHECK_FALSE(ran_nothing(scene.step(2.0 * kStep)));
    return;
  }
  SECTION("a step that is none") {
    CHECK(scene.step(-1.0).status == pbd::StepStatus::InvalidStep);
    CHECK(scene.step(kStep).status == pbd::StepStatus::Ok);
    return;
  }
  SECTION("a solver under which nothing sleeps") {
    pbd::Solver sleepless({.sleep_after = 0.0});
    sleepless.step(scene.world(), kStep);
    REQUIRE(scene.world().awake(cube));
  }
  SECTION("a copy is brought back") {
    pbd::WorldCopy copy;
    REQUIRE(copy.assign(scene.world()));
    copy.set_state(cube.index, {.pose = {.position = {5.0, 5.0, 2.0}}}, true);
    copy.restore(scene.world());
    scene.step(kStep);
    CHECK(scene.pose(cube).position.z() < 2.0);
    return;
  }
  CHECK_FALSE(ran_nothing(scene.step(kStep)));
}

}  // namespace
}  // namespace still_test
