// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/car.h"
#include "tandem/cloth.h"
#include "tandem/ragdoll.h"
#include "tandem/rope.h"

namespace whole_test {

using namespace tandem;
using tandem::testing::refusal;

constexpr double kStep = 1.0 / 60.0;

/// All that an add may leave behind.
struct Count {
  std::size_t bodies = 0, colliders = 0, blocks = 0;
  int rows = 0;
  friend bool operator==(const Count&, const Count&) = default;
};

Count count(const Scene& scene) {
  Count out{.bodies = scene.world().body_count(), .blocks = scene.world().blocks().size()};
  for (std::uint32_t i = 0; i < scene.shapes().slot_count(); ++i) {
    if (scene.shapes().collider_at(i).valid()) ++out.colliders;
  }
  for (const auto& block : scene.world().blocks()) out.rows += block->report().rows;
  return out;
}

std::uint64_t run(Scene& scene) {
  for (int i = 0; i < 60; ++i) scene.step(kStep);
  return scene.world().hash();
}

/// A refused call changes nothing: later motion is as if it had not been made.
/// @param good  adds as many bodies as any of `bad` does
void check_whole(const std::function<void(Scene&)>& good,
                 const std::vector<std::function<void(Scene&)>>& bad) {
  for (const bool first : {false, true}) {  // of its kind in the scene
    Scene scene, other;
    for (Scene* each : {&scene, &other}) {
      each->add(HalfSpace{}, {.type = BodyType::Static});
      if (!first) good(*each);
    }
    const Count before = count(scene);
    for (std::size_t i = 0; i < bad.size(); ++i) {
      CAPTURE(first, i);
      CHECK_FALSE(refusal([&] { bad[i](scene); }).empty());
      CHECK(count(scene) == before);
    }
    good(scene);
    good(other);
    CHECK(run(scene) == run(other));
  }
}

TEST_CASE("scene: a car, ragdoll, rope or cloth is added whole or not at all", "[scene][input]") {
  constexpr double kTooLarge = 1e7;                                        // m, for a shape
  constexpr double kTooSmall = std::numeric_limits<double>::denorm_min();  // for its inverse
  const Pose high{.position = {0.0, 0.0, 1.0}};
  check_whole([&](Scene& s) { Car(s, {.pose = high}); },
              {[&](Scene& s) { Car(s, {.pose = high, .wheel_radius = kTooLarge}); },
               [&](Scene& s) { Car(s, {.pose = high, .wheel_mass = kTooSmall}); }});
  check_whole([&](Scene& s) { Ragdoll(s, {.pose = high}); },
              {[&](Scene& s) { Ragdoll(s, {.pose = high, .height = kTooLarge}); },
               [&](Scene& s) { Ragdoll(s, {.pose = high, .mass = 4e-307}); }});
  check_whole(
      [&](Scene& s) {
        Rope(s, {.from = {0.0, 0.0, 1.0}, .to = {1.0, 0.0, 1.0}});
      },
      {[&](Scene& s) { Rope(s, {.radius = kTooLarge}); },
       [&](Scene& s) { Rope(s, {.compliance = -1.0}); },
       [&](Scene& s) { Rope(s, {.bending = kTooSmall}); }});
  check_whole([&](Scene& s) { Cloth(s, {.pose = high, .columns = 8, .rows = 8}); },
              {[&](Scene& s) { Cloth(s, {.columns = 8, .rows = 8, .radius = kTooLarge}); },
               [&](Scene& s) { Cloth(s, {.columns = 8, .rows = 8, .bending = kTooSmall}); }});
}

TEST_CASE("scene: a joint that is refused leaves no block of joints", "[scene][input]") {
  Scene scene;
  const BodyId body = scene.add(Sphere{0.1});
  const Count before = count(scene);
  CHECK_FALSE(refusal([&] { scene.add_joint({.a = body, .b = body}); }).empty());
  CHECK(count(scene) == before);
}

TEST_CASE("cloth: tethers and handles are added whole or not at all", "[scene][input]") {
  Scene scene;
  // Just heavy enough.
  Cloth cloth(scene, {.columns = 5, .rows = 5, .density = 1.6e-100, .radius = 1.0});
  cloth.attach(0, 0, scene.add(Box{1.0, 1.0, 1.0}, {.type = BodyType::Static}));
  const auto mass = [&](int column, int row) {
    return scene.world().props(cloth.particle(column, row)).mass;
  };
  const double at_side = mass(1, 2), in_middle = mass(2, 2);
  Count before = count(scene);
  CHECK_FALSE(refusal([&] { cloth.add_handle(0.5, 0.5, 0.6, 0.9999999); }).empty());
  CHECK(count(scene) == before);
  CHECK(mass(1, 2) == at_side);
  CHECK(mass(2, 2) == in_middle);

  scene.remove(cloth.particle(3, 4));
  before = count(scene);
  CHECK_FALSE(refusal([&] { cloth.tether(); }).empty());
  CHECK(count(scene) == before);
}

}  // namespace whole_test
