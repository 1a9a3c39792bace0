// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The examples of the documentation: they must compile and do what they say.
#include "support/catch.h"
#include "tandem/collision/contact_events.h"
#include "tandem/collision/scene_query.h"
#include "tandem/pbd/solver.h"

namespace usage_test {

using namespace tandem;

TEST_CASE("usage: materials, filters and sensors", "[collision][usage]") {
  pbd::World world;
  collision::CollisionScene scene;
  world.set_contact_source(&scene);

  const collision::Material ice{.friction = 0.02, .friction_rule = collision::Combine::Minimum};
  const collision::Filter debris{.category = 4, .mask = 1, .group = -1};  // never with its like
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}, .material = ice});
  const pbd::BodyId shard = world.add_body({.pose = {.position = pbd::Vec3(0, 0, 2)}});
  const auto id = scene.add(world, {.body = shard, .shape = collision::Box{}, .filter = debris});
  scene.add(world, {.body = ground, .shape = collision::Sphere{1.0}, .sensor = true});
  scene.set_filter(id, {.category = 4});  // from the next step on

  CHECK(scene.collider(id).filter.category == 4);
  CHECK(scene.sensor_count() == 1);
}

TEST_CASE("usage: events", "[collision][usage]") {
  pbd::World world;
  collision::CollisionScene scene;
  world.set_contact_source(&scene);
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  scene.add(world, {.body = ground, .shape = collision::Sphere{1.0}, .sensor = true});
  const pbd::BodyId ball = world.add_body({.pose = {.position = pbd::Vec3(0, 0, 2)}});
  scene.add(world, {.body = ball, .shape = collision::Sphere{0.1}});
  int touched = 0;
  int entered = 0;

  pbd::Solver solver;
  collision::ContactEvents events({.hit_speed = 2.0});
  for (int i = 0; i < 120; ++i) {
    if (solver.step(world, 1.0 / 60.0).status != pbd::StepStatus::Ok) break;
    events.update(world, scene);
    for (const collision::ContactHit& hit : events.hits()) CHECK(hit.speed > 2.0);
    for (const collision::ContactPair& pair : events.begun()) touched += pair.body_b == ball;
    for (const collision::SensorPair& pair : events.sensor_begun()) {
      entered += pair.visitor_body == ball;
    }
  }

  CHECK(touched == 1);
  CHECK(entered == 1);
}

TEST_CASE("usage: queries", "[collision][usage]") {
  pbd::World world;
  collision::CollisionScene scene;
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  const pbd::BodyId crate = world.add_body({.pose = {.position = pbd::Vec3(3, 0, 0.5)}});
  scene.add(world, {.body = crate, .shape = collision::Box{}});
  const pbd::Vec3 eye(0, 0, 0.4);

  collision::SceneQuery query(world, scene);
  query.update(world, scene);  // whenever bodies have moved
  const auto hit = query.ray_cast({.origin = eye, .direction = pbd::Vec3::UnitX()});
  const auto step = query.shape_cast(collision::Capsule{0.3, 0.5}, {.position = pbd::Vec3(0, 0, 1)},
                                     pbd::Vec3(4, 0, 0), {.ignore_body = ground});
  std::vector<collision::ColliderId> found;
  query.overlap(collision::Sphere{2.8}, {.position = eye}, found);
  const auto nearest = query.closest(eye, 10.0, {.ignore_body = ground});

  REQUIRE(hit);
  CHECK(hit->body == crate);
  CHECK(hit->distance == Approx(2.5));
  REQUIRE(step);
  CHECK(step->fraction == Approx(2.2 / 4.0));
  CHECK(found.size() == 2);
  REQUIRE(nearest);
  CHECK(nearest->distance == Approx(2.5));
}

}  // namespace usage_test
