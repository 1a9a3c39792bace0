// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_events.h"

#include <cmath>
#include <numbers>

#include "allocation_count.h"
#include "fixture.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/solver.h"

namespace contact_events_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
namespace pbd = tandem::pbd;

namespace {

/// A world that is stepped, and its events.
struct Stage : Fixture {
  pbd::Solver solver;
  ContactEvents events;
  int begun = 0;
  int ended = 0;
  int entered = 0;
  int left = 0;
  std::vector<ContactHit> hits;

  explicit Stage(const ContactEventOptions& options = {}) : events(options) {
    world.set_contact_source(&scene);
  }
  void step(int count = 1) {
    for (int i = 0; i < count; ++i) {
      REQUIRE(solver.step(world, kDt).status == pbd::StepStatus::Ok);
      look();
    }
  }
  void look() {
    events.update(world, scene);
    begun += static_cast<int>(events.begun().size());
    ended += static_cast<int>(events.ended().size());
    entered += static_cast<int>(events.sensor_begun().size());
    left += static_cast<int>(events.sensor_ended().size());
    hits.insert(hits.end(), events.hits().begin(), events.hits().end());
  }
  ColliderId sensor(const Shape& shape, const Pose& pose, const Filter& filter = {}) {
    return scene.add(
        world,
        {.body = body(pose, BodyType::Static), .shape = shape, .filter = filter, .sensor = true});
  }
};

}  // namespace

TEST_CASE("contact_events: a body that comes to rest begins once and stays",
          "[collision][events]") {
  const auto ground = GENERATE(0, 1);
  Stage s;
  if (ground == 0) {
    s.fixed(HalfSpace{});
  } else {
    s.fixed(flat_mesh(10.0, 8));
  }
  s.add(Box{Vec3::Constant(0.5)}, at(0.1, 0.2, 0.6));
  s.add(Box{Vec3::Constant(0.5)}, at(0.12, 0.2, 1.7));
  s.add(Sphere{0.3}, at(2.1, 0.2, 0.4));
  s.add(Capsule{0.3, 0.4}, at(Vec3(-2, 0, 0.4), Vec3(0, std::numbers::pi / 2, 0)));
  s.step(600);
  CHECK(s.begun == 4);
  CHECK(s.ended == 0);
  REQUIRE(s.events.touching().size() == 4);
  CHECK(std::is_sorted(s.events.touching().begin(), s.events.touching().end()));
  CHECK(s.events.touching()[0].a.index == 0);
  CHECK(s.events.touching()[0].b.index == 1);
}

TEST_CASE("contact_events: each bounce begins, hits with the fall's speed, and ends",
          "[collision][events][analytic]") {
  Stage s;
  s.fixed(HalfSpace{});
  const BodyId ball = s.body(at(0, 0, 2.5));
  s.scene.add(s.world, {.body = ball, .shape = Sphere{0.5}, .material = {.restitution = 0.8}});
  s.step(150);  // 0.64 s to fall 2 m, then 1.02 s, 0.82 s, ...
  const double speed = std::sqrt(2.0 * 9.81 * 2.0);
  REQUIRE(s.hits.size() >= 2);
  CHECK(s.begun == static_cast<int>(s.hits.size()));
  CHECK(s.begun - s.ended <= 1);
  CHECK(s.hits[0].speed == Approx(speed).epsilon(0.02));
  CHECK(s.hits[1].speed == Approx(0.8 * speed).epsilon(0.03));
  CHECK(s.hits[0].impulse == Approx(1.8 * speed).epsilon(0.03));  // of 1 kg
  CHECK((s.hits[0].normal - Vec3::UnitZ()).norm() < 1e-9);
  CHECK(std::abs(s.hits[0].point.z()) < 0.1);
  CHECK(s.hits[0].pair.body_b == ball);
}

TEST_CASE("contact_events: a soft touch is no hit", "[collision][events]") {
  Stage s(ContactEventOptions{.hit_speed = 3.0});
  s.fixed(HalfSpace{});
  s.add(Sphere{0.5}, at(0, 0, 0.9));  // 2.8 m/s
  s.add(Sphere{0.5}, at(2, 0, 1.1));  // 3.4 m/s
  s.step(60);
  REQUIRE(s.hits.size() == 1);
  CHECK(s.hits[0].pair.b.index == 2);
  CHECK(s.begun == 2);
}

TEST_CASE("contact_events: a removed collider, a removed body and a filter end their contacts",
          "[collision][events]") {
  Stage s;
  s.fixed(HalfSpace{});
  const BodyId first = s.add(Sphere{0.5}, at(0, 0, 0.5));
  s.add(Sphere{0.5}, at(2, 0, 0.5));
  s.add(Sphere{0.5}, at(4, 0, 0.5));
  s.step(5);
  CHECK(s.begun == 3);
  s.world.remove_body(first);
  s.scene.remove({2, 0});
  s.scene.set_filter({3, 0}, {.mask = 0, .group = -1});
  s.step();
  CHECK(s.ended == 3);
  REQUIRE(s.events.ended().size() == 3);
  CHECK(s.events.ended()[0].body_b == first);
  CHECK_FALSE(s.scene.contains(s.events.ended()[0].b));
  s.step(5);
  CHECK(s.ended == 3);
  CHECK(s.begun == 3);
}

TEST_CASE("contact_events: a sensor reports entries and exits exactly", "[collision][events]") {
  Stage s;
  s.world.set_gravity(Vec3::Zero());
  const ColliderId zone = s.sensor(Box{Vec3::Constant(1.0)}, at(0, 0, 0));
  const BodyId ball = s.add(Sphere{0.5}, at(-3.01, 0, 0));
  const BodyId beside = s.add(Sphere{0.5}, at(1.4, 1.4, 0));  // boxes meet, shapes do not
  s.world.set_twist(ball, {Vec3(3, 0, 0), Vec3::Zero()});
  double from = 0.0;
  double to = 0.0;
  for (int i = 0; i < 180; ++i) {
    s.step();
    if (s.events.sensor_begun().size() == 1) from = s.world.pose(ball).position.x();
    if (s.events.sensor_ended().size() == 1) to = s.world.pose(ball).position.x();
    for (const SensorPair& pair : s.events.in_sensors()) {
      CHECK(pair.sensor == zone);
      CHECK(pair.visitor_body == ball);
      CHECK(pair.visitor_body != beside);
    }
  }
  CHECK(s.entered == 1);
  CHECK(s.left == 1);
  CHECK(from >= -1.5);
  CHECK(from < -1.5 + 3.0 * kDt);
  CHECK(to > 1.5);
  CHECK(to <= 1.5 + 3.0 * kDt);
  CHECK(s.world.twist(ball).linear.x() == Approx(3.0));  // it is not solved
  CHECK(s.begun == 0);
}

TEST_CASE("contact_events: a sensor sees a body that flies through it in a step, not a jump",
          "[collision][events]") {
  Stage s;
  s.world.set_gravity(Vec3::Zero());
  s.sensor(Box{Vec3(0.01, 1, 1)}, at(0, 0, 0));
  const BodyId bullet = s.add(Sphere{0.05}, at(-9.9, 0, 0));
  const BodyId miss = s.add(Sphere{0.05}, at(-9.9, 1.2, 0));
  const BodyId jumper = s.add(Sphere{0.05}, at(-5, 0, 0));
  s.step();
  s.world.set_twist(bullet, {Vec3(300, 0, 0), Vec3::Zero()});  // 5 m a step
  s.world.set_twist(miss, {Vec3(300, 0, 0), Vec3::Zero()});
  s.step();
  s.world.set_pose(jumper, at(5, 0, 0));
  s.step(3);
  CHECK(s.entered == 1);
  CHECK(s.left == 1);
  CHECK(s.events.in_sensors().empty());
}

TEST_CASE("contact_events: a moving sensor sees the bodies that it sweeps over",
          "[collision][events]") {
  Stage s;
  s.world.set_gravity(Vec3::Zero());
  const BodyId arm = s.body(at(-5, 0, 0), BodyType::Kinematic);
  s.scene.add(s.world, {.body = arm, .shape = Box{Vec3(0.01, 1, 1)}, .sensor = true});
  const BodyId rock = s.fixed(Sphere{0.05}, at(0, 0, 0));
  s.fixed(Sphere{0.05}, at(0, 1.2, 0));
  s.step();
  s.world.set_twist(arm, {Vec3(400, 0, 0), Vec3::Zero()});
  s.step();
  REQUIRE(s.events.sensor_begun().size() == 1);
  CHECK(s.events.sensor_begun()[0].visitor_body == rock);
  CHECK(s.events.sensor_ended().size() == 1);
  s.step(2);
  CHECK(s.entered == 1);
}

TEST_CASE("contact_events: filters hold for sensors, of every shape", "[collision][events]") {
  Stage s;
  s.world.set_gravity(Vec3::Zero());
  s.sensor(Sphere{1.0}, at(0, 0, 0), {.mask = 2});
  s.sensor(HalfSpace{}, at(0, 0, 0));
  s.sensor(box_mesh(Vec3(2, 2, 2)), at(0, 0, 0));
  s.sensor(Sphere{1.0}, at(0, 0, 0));  // sensors do not see each other
  s.fixed(Box{}, at(0, 0, 0.4));       // nor do static bodies count for static sensors
  s.add(Box{Vec3::Constant(0.1)}, at(1.5, 0, 0.5));
  s.add(flat_mesh(1.0, 2), at(0, 0, -0.5));
  s.step();
  // The small box is in the mesh; the mesh body is under the plane and in the last ball.
  REQUIRE(s.events.in_sensors().size() == 3);
  CHECK(s.events.in_sensors()[0].sensor.index == 1);
  CHECK(s.events.in_sensors()[0].visitor.index == 6);
  CHECK(s.events.in_sensors()[1].sensor.index == 2);
  CHECK(s.events.in_sensors()[1].visitor.index == 5);
  CHECK(s.events.in_sensors()[2].sensor.index == 3);
  CHECK(s.events.in_sensors()[2].visitor.index == 6);
}

TEST_CASE("contact_events: after a restore the same events come again", "[collision][events]") {
  Stage s;
  s.fixed(HalfSpace{});
  s.sensor(Box{Vec3(3, 3, 0.2)}, at(0, 0, 1.0));
  for (int i = 0; i < 4; ++i) {
    const BodyId id = s.body(at(0.3 * i, 1.2 * i, 1.6 + 0.4 * i));
    s.scene.add(s.world, {.body = id, .shape = Sphere{0.3}, .material = {.restitution = 0.6}});
  }
  s.step(25);
  const auto saved_world = s.world.snapshot();
  std::vector<std::byte> saved_events;
  pbd::ByteWriter out(saved_events);
  s.events.save(out);
  const auto record = [&] {
    std::vector<std::vector<ContactPair>> begun;
    std::vector<std::vector<SensorPair>> left;
    for (int i = 0; i < 60; ++i) {
      s.step();
      begun.emplace_back(s.events.begun().begin(), s.events.begun().end());
      left.emplace_back(s.events.sensor_ended().begin(), s.events.sensor_ended().end());
    }
    return std::pair(begun, left);
  };
  const auto first = record();
  CHECK(s.begun > 4);
  CHECK(s.left > 4);
  s.world.restore(saved_world);
  pbd::ByteReader in(saved_events);
  s.events.load(in);
  REQUIRE_FALSE(in.failed());
  CHECK(in.remaining() == 0);
  CHECK(record() == first);

  saved_events[1] = std::byte{7};
  pbd::ByteReader bad(saved_events);
  s.events.load(bad);
  CHECK(bad.failed());
  CHECK(s.events.touching().empty());
}

TEST_CASE("contact_events: a steady state allocates nothing", "[collision][events]") {
  Stage s;
  s.fixed(HalfSpace{});
  s.sensor(Box{Vec3::Constant(1.0)}, at(0, 0, 0.5));
  for (int i = 0; i < 8; ++i) s.add(Sphere{0.3}, at(0.7 * i, 0, 0.35));
  s.step(60);
  const AllocationCount count;
  for (int i = 0; i < 20; ++i) s.events.update(s.world, s.scene);
  CHECK(count.count() == 0);
}

TEST_CASE("contact_events: options out of range are refused by name", "[collision][fault]") {
  CHECK_THROWS_WITH(ContactEvents({.hit_speed = 0.0}),
                    Contains("hit_speed must be") && Contains("is 0"));
  CHECK_THROWS_WITH(ContactEvents({.release_gap = NAN}),
                    Contains("release_gap must be") && Contains("is nan"));
}

}  // namespace contact_events_test
