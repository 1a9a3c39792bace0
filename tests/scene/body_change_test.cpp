// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Mass and kind of bodies that live, with shapes and neighbours.
#include <cmath>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/scene.h"

namespace body_change_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kStep = 1.0 / 60.0;

void run(Scene& scene, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / kStep)); ++i) scene.step(kStep);
}

TEST_CASE("body change: a heavier body keeps its velocity and hits as one", "[scene][change]") {
  Scene scene({.gravity = Vec3::Zero()});
  const BodyId ball =
      scene.add(Sphere{0.1}, {.mass = 1.0, .twist = {Vec3(2.0, 0.0, 0.0), Vec3::Zero()}});
  const BodyId other = scene.add(Sphere{0.1}, {.mass = 1.0, .pose = {.position = {1.0, 0.0, 0.0}}});
  run(scene, 0.1);
  scene.world().set_mass(ball, 3.0);
  CHECK(scene.world().twist(ball).linear.x() == 2.0);
  CHECK(scene.world().props(ball).inertia(0, 0) == Approx(0.4 * 3.0 * 0.01));
  CHECK(scene.world().kinetic_energy() == Approx(0.5 * 3.0 * 4.0));
  run(scene, 1.0);
  // Without bounce: 3 kg at 2 m/s take 1 kg along.
  CHECK(scene.world().twist(other).linear.x() == Approx(1.5).epsilon(1e-3));
  CHECK(scene.world().twist(ball).linear.x() == Approx(1.5).epsilon(1e-3));
}

TEST_CASE("body change: a body made static stops and holds", "[scene][change]") {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId shelf = scene.add(Box{0.5, 0.5, 0.1}, {.pose = {.position = {0.0, 0.0, 3.0}}});
  const BodyId ball = scene.add(Sphere{0.1}, {.pose = {.position = {0.0, 0.0, 4.0}}});
  run(scene, 0.3);
  scene.world().apply_force(shelf, Vec3(1e5, 0.0, 0.0));
  scene.world().set_type(shelf, BodyType::Static);
  const Pose there = scene.pose(shelf);
  run(scene, 2.0);
  CHECK(scene.pose(shelf).position == there.position);
  CHECK(scene.world().twist(shelf).linear.isZero(0.0));
  CHECK(scene.pose(ball).position.z() - there.position.z() == Approx(0.2).margin(2e-3));

  scene.world().set_mass(shelf, 10.0, pbd::Mat3::Identity());
  run(scene, 3.0);
  CHECK(scene.pose(shelf).position.z() == Approx(0.1).margin(2e-3));  // and falls again
  CHECK(scene.pose(ball).position.z() < 0.5);
}

TEST_CASE("body change: a lighter body falls slower", "[scene][change]") {
  Scene scene;
  const BodyId ball = scene.add(Sphere{0.1});
  scene.world().set_gravity_scale(ball, 0.25);
  run(scene, 1.0);
  CHECK(scene.world().twist(ball).linear.z() == Approx(-0.25 * 9.81));
  CHECK(names(refusal([&] { scene.world().set_gravity_scale(ball, NAN); }), "scale", "nan",
              "finite"));
}

TEST_CASE("body change: a body without its ground falls; live colliders' data change",
          "[scene][change]") {
  Scene scene;
  const BodyId ground = scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId ball =
      scene.add(Sphere{0.1}, {.pose = {.position = {0.0, 0.0, 0.1}}, .user_data = 7});
  run(scene, 2.0);
  const collision::ColliderId floor = scene.shapes().collider_at(0);
  const collision::ColliderId sphere = scene.shapes().collider_at(1);
  REQUIRE(scene.shapes().collider(floor).body == ground);
  CHECK(scene.shapes().collider(sphere).user_data == 7);
  scene.shapes().set_user_data(sphere, 8);
  CHECK(scene.shapes().collider(sphere).user_data == 8);
  CHECK_THROWS_AS(scene.shapes().set_user_data({}, 8), std::invalid_argument);
  CHECK(scene.pose(ball).position.z() == Approx(0.1).margin(1e-3));
  scene.shapes().remove(floor);
  scene.world().wake(ball);
  run(scene, 1.0);
  CHECK(scene.pose(ball).position.z() == Approx(0.1 - 0.5 * 9.81).epsilon(0.02));
}

TEST_CASE("body change: sleeping neighbours wake", "[scene][change]") {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  std::vector<BodyId> pile;
  for (int i = 0; i < 3; ++i) {
    pile.push_back(
        scene.add(Box{0.1, 0.1, 0.1}, {.pose = {.position = {0.0, 0.0, 0.1 + 0.2 * i}}}));
  }
  run(scene, 4.0);
  for (const BodyId box : pile) REQUIRE_FALSE(scene.world().awake(box));
  const int change = GENERATE(0, 1, 2);
  if (change == 0) scene.world().set_mass(pile[1], 50.0);
  if (change == 1) scene.world().set_type(pile[1], BodyType::Static);
  if (change == 2) scene.world().set_type(pile[1], BodyType::Kinematic);
  CHECK(scene.world().awake(pile[0]));
  CHECK(scene.world().awake(pile[2]));
  if (change == 2) scene.world().set_twist(pile[1], {Vec3(0.5, 0.0, 0.0), Vec3::Zero()});
  run(scene, 1.0);
  CHECK(scene.pose(pile[2]).position.z() == Approx(0.5).margin(5e-3));
  if (change == 2) {
    CHECK(scene.pose(pile[1]).position.x() == Approx(0.5));
    CHECK(scene.pose(pile[2]).position.x() > 0.3);  // carried by friction
  }
  // A snapshot of it can be restored.
  const auto bytes = scene.world().snapshot();
  const auto hash = scene.world().hash();
  run(scene, 0.2);
  scene.world().restore(bytes);
  CHECK(scene.world().hash() == hash);
}

TEST_CASE("body change: errors name field, value and rule", "[scene][change]") {
  Scene scene;
  const BodyId box = scene.add(Box{0.1, 0.1, 0.1});
  const BodyId wall = scene.add(Box{0.1, 0.1, 0.1}, {.type = BodyType::Static});
  pbd::World& world = scene.world();
  CHECK(names(refusal([&] { world.set_mass(box, 0.0); }), "mass", "0", "> 0"));
  CHECK(names(refusal([&] { world.set_mass(wall, 1.0); }), "set_mass", "body 1", "dynamic"));
  CHECK(names(refusal([&] { world.set_mass(wall, 1.0, -pbd::Mat3::Identity()); }), "inertia", "-1",
              "positive"));
  CHECK(names(refusal([&] { world.set_type(wall, BodyType::Dynamic); }), "type", "2", "set_mass"));
  CHECK(world.props(wall).type == BodyType::Static);
  world.set_mass(wall, 1.0, pbd::Mat3::Identity());
  CHECK(world.props(wall).type == BodyType::Dynamic);
}

}  // namespace body_change_test
