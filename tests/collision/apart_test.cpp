// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/world_copy.h"

/// Pairs of bodies that do not touch each other: those of one joint, and those that somebody named.
namespace apart_test {

using namespace tandem::collision;
using namespace tandem::pbd;
using tandem::testing::ball_def;
using tandem::testing::names;
using tandem::testing::refusal;
using tandem::testing::weightless;

/// Balls of 1 kg and 0.1 m, by default without weight.
struct Balls {
  World world;
  CollisionScene shapes;
  JointBlock* joints = nullptr;
  Solver solver;

  explicit Balls(const WorldDef& def = weightless(), const SolverOptions& options = {})
      : world(def), joints(&world.add_block<JointBlock>()), solver(options) {
    world.set_contact_source(&shapes);
  }
  BodyId add(const Vec3& position, bool bullet = false) {
    BodyDef def = ball_def(1.0, 0.1, position);
    def.bullet = bullet;
    const BodyId id = world.add_body(def);
    shapes.add(world, {.body = id, .shape = Sphere{0.1}});
    return id;
  }
  JointId join(BodyId a, BodyId b, bool touch) {
    HingeJointDef def = hinge_joint_at(
        world, a, b, 0.5 * (world.pose(a).position + world.pose(b).position), Vec3::UnitZ());
    def.collide_connected = touch;
    return joints->add(world, def);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) CHECK(solver.step(world, 1.0 / 60.0).status == StepStatus::Ok);
  }
  std::size_t contacts() const { return world.contacts()->contacts().size(); }
  double apart(BodyId a, BodyId b) const {
    return (world.pose(a).position - world.pose(b).position).norm();
  }
};

TEST_CASE("apart: bodies of a joint that overlap do not feel it", "[collision][apart]") {
  Balls scene;
  const BodyId a = scene.add(Vec3(0.0, 0.0, 0.0));
  const BodyId b = scene.add(Vec3(0.1, 0.0, 0.0));
  const BodyId third = scene.add(Vec3(0.28, 0.0, 0.0));  // overlaps b by 2 cm
  scene.join(a, b, false);
  scene.run(1);
  REQUIRE(scene.contacts() == 1);
  CHECK(scene.world.contacts()->contacts()[0].manifold.body_b == third.index);
  scene.run(60);
  CHECK(scene.apart(a, b) == Approx(0.1).margin(1e-9));
  CHECK(scene.apart(b, third) > 0.195);

  Balls touching;
  const BodyId c = touching.add(Vec3(0.0, 0.0, 0.0));
  touching.join(c, touching.add(Vec3(0.1, 0.0, 0.0)), true);
  touching.run(1);
  CHECK(touching.contacts() == 1);
}

TEST_CASE("apart: bodies touch again when their joint is off, broken or gone",
          "[collision][apart]") {
  const int way = GENERATE(0, 1, 2, 3);
  INFO("way " << way);
  Balls scene;
  const BodyId a = scene.add(Vec3(0.0, 0.0, 0.0));
  const BodyId b = scene.add(Vec3(0.1, 0.0, 0.0));
  const JointId joint = scene.join(a, b, false);
  scene.run(120);
  REQUIRE_FALSE(scene.world.contacts()->contacts().size() > 0);
  SixDofJointDef def = scene.joints->def(joint);
  if (way == 0) scene.joints->set_enabled(joint, false);
  if (way == 1) scene.joints->remove(joint);
  if (way == 2) {
    def.collide_connected = true;
    scene.joints->set(scene.world, joint, def);
    scene.run(1);
    CHECK(scene.contacts() == 1);
    return;
  }
  if (way == 3) {
    def.break_force = 1.0;
    scene.joints->set(scene.world, joint, def);
    scene.world.apply_impulse(b, Vec3(0.0, 1.0, 0.0));
    scene.run(2);
    REQUIRE(scene.joints->at(joint).broken);
  }
  scene.run(60);
  CHECK(scene.apart(a, b) > 0.195);
}

TEST_CASE("apart: named pairs pass through each other, all others touch", "[collision][apart]") {
  Balls scene({}, {.sleep_after = 0.0});
  const BodyId floor = scene.world.add_body({.type = BodyType::Static});
  scene.shapes.add(scene.world, {.body = floor, .shape = Box{Vec3(2.0, 2.0, 0.005)}});
  const BodyId lies = scene.add(Vec3(0.0, 0.0, 0.2));
  const BodyId falls = scene.add(Vec3(0.5, 0.0, 0.2));
  const BodyId shot = scene.add(Vec3(1.0, 0.0, 2.0), true);
  scene.world.set_twist(shot, {Vec3(0.0, 0.0, -200.0), Vec3::Zero()});
  scene.shapes.set_apart(scene.world, floor, falls);
  scene.shapes.set_apart(scene.world, shot, floor);
  CHECK(scene.shapes.is_apart(falls, floor));
  CHECK_FALSE(scene.shapes.is_apart(lies, floor));
  scene.run(60);
  CHECK(scene.world.pose(lies).position.z() == Approx(0.105).margin(1e-3));
  CHECK(scene.world.pose(falls).position.z() < -3.0);
  CHECK(scene.world.pose(shot).position.z() < -150.0);
}

TEST_CASE("apart: bodies that are named while they touch let go, and touch again",
          "[collision][apart]") {
  Balls scene(WorldDef{});
  const BodyId floor = scene.world.add_body({.type = BodyType::Static});
  scene.shapes.add(scene.world, {.body = floor, .shape = HalfSpace{}});
  const BodyId ball = scene.add(Vec3(0.0, 0.0, 0.1));
  scene.run(120);
  REQUIRE_FALSE(scene.world.awake(ball));
  scene.shapes.set_apart(scene.world, ball, floor);
  scene.run(6);
  CHECK(scene.world.pose(ball).position.z() < 0.06);
  scene.shapes.set_apart(scene.world, floor, ball, false);
  scene.run(60);
  CHECK(scene.world.pose(ball).position.z() == Approx(0.1).margin(1e-3));
}

TEST_CASE("apart: snapshots and copies go on with the same bits", "[collision][apart]") {
  Balls scene(WorldDef{});
  const BodyId floor = scene.world.add_body({.type = BodyType::Static});
  scene.shapes.add(scene.world, {.body = floor, .shape = HalfSpace{}});
  const BodyId a = scene.add(Vec3(0.0, 0.0, 0.3));
  const BodyId b = scene.add(Vec3(0.12, 0.0, 0.3));
  const BodyId c = scene.add(Vec3(0.05, 0.1, 0.35));
  scene.join(a, b, false);
  scene.shapes.set_apart(scene.world, a, c);
  scene.run(20);
  const std::vector<std::byte> bytes = scene.world.snapshot();
  WorldCopy copy;
  copy.assign(scene.world);
  scene.run(60);
  const std::uint64_t hash = scene.world.hash();
  for (int i = 0; i < 60; ++i) scene.solver.step(copy.world(), 1.0 / 60.0);
  CHECK(copy.world().hash() == hash);
  scene.shapes.set_apart(scene.world, a, c, false);
  scene.run(7);
  scene.world.restore(bytes);
  CHECK(scene.shapes.is_apart(a, c));
  scene.run(60);
  CHECK(scene.world.hash() == hash);
}

TEST_CASE("apart: a body that takes a removed one's place touches", "[collision][apart]") {
  Balls scene;
  const BodyId a = scene.add(Vec3(0.0, 0.0, 0.0));
  const BodyId b = scene.add(Vec3(0.15, 0.0, 0.0));
  scene.shapes.set_apart(scene.world, a, b);
  scene.run(1);
  REQUIRE(scene.contacts() == 0);
  scene.world.remove_body(b);
  const BodyId next = scene.add(Vec3(0.15, 0.0, 0.0));
  REQUIRE(next.index == b.index);
  CHECK_FALSE(scene.shapes.is_apart(a, next));
  scene.run(1);
  CHECK(scene.contacts() == 1);
}

TEST_CASE("apart: errors name an invalid pair of bodies", "[collision][apart]") {
  Balls scene;
  const BodyId a = scene.add(Vec3::Zero());
  CHECK(names(refusal([&] { scene.shapes.set_apart(scene.world, a, a); }), "set_apart", "b",
              "another body than a"));
  CHECK(names(refusal([&] { scene.shapes.set_apart(scene.world, a, {}); }), "set_apart", "b", ""));
  CHECK(scene.shapes.apart().empty());
}

}  // namespace apart_test
