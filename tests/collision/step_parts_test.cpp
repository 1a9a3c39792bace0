// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "fixture.h"
#include "support/targets.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace step_parts_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using namespace tandem::pbd;

namespace {

/// The names of the stages that ran, in order.
std::string stages(const StepReport& report) {
  std::string names;
  for (std::size_t i = 0; i < kStageNames.size(); ++i) {
    if (report.ran[i]) names += std::string(names.empty() ? "" : " ") + std::string(kStageNames[i]);
  }
  return names;
}

std::vector<BodyId> rain(Fixture& f, const Shape& shape, const Material& material, int count) {
  Random random(9);
  std::vector<BodyId> ids;
  const auto add = [&](const Shape& what, const BodyDef& def) {
    const BodyId id = f.world.add_body(def);
    ColliderDef collider;
    collider.body = id;
    collider.shape = what;
    collider.material = material;
    f.scene.add(f.world, collider);
    return id;
  };
  BodyDef ground;
  ground.type = BodyType::Static;
  add(HalfSpace{}, ground);
  for (const double side : {-1.0, 1.0}) {  // walls, so that they stay together
    for (const int axis : {0, 1}) add(HalfSpace{-side * Vec3::Unit(axis), -1.0}, ground);
  }
  const MassProperties properties = mass_properties(shape, 300.0);
  for (int i = 0; i < count; ++i) {
    BodyDef def;
    def.mass = properties.mass;
    def.inertia = properties.inertia;
    def.pose.position = Vec3(random.in(-0.7, 0.7), random.in(-0.7, 0.7), 0.3 + 0.2 * i);
    ids.push_back(add(shape, def));
  }
  f.world.set_contact_source(&f.scene);
  return ids;
}

}  // namespace

TEST_CASE("parts: free bodies run neither rows nor rotation", "[collision][unit]") {
  World world;
  for (int i = 0; i < 5; ++i) world.add_body({.pose = at(i, 0, 0)});
  Solver solver;
  const StepReport& report = solver.step(world, kDt);
  CHECK(stages(report) == "begin integrate end");
  CHECK_FALSE(report.parts.contacts);
  CHECK_FALSE(report.parts.joints);
  CHECK_FALSE(report.parts.rotation);
  CHECK_FALSE(report.parts.refinement);
  CHECK(report.turning == 0);
  CHECK(report.velocity_iterations == 0);
  // One that spins is turned, and no other.
  world.set_twist(world.body_at(2), {Vec3::Zero(), Vec3(0, 0, 1)});
  CHECK(solver.step(world, kDt).turning == 1);
  CHECK(report.parts.rotation);
  // A torque and a joint may turn it too.
  world.apply_torque(world.body_at(0), Vec3(0.1, 0, 0));
  auto& joints = world.add_block<JointBlock>();
  joints.add(world, ball_joint_at(world, world.body_at(3), world.body_at(4), Vec3(3.5, 0, 0)));
  CHECK(solver.step(world, kDt).turning == 4);
  CHECK(stages(report) == "begin integrate project velocity end");
  CHECK(report.parts.joints);
  CHECK_FALSE(report.parts.contacts);
}

TEST_CASE("parts: spheres without friction fall, collide and pile up without any rotation",
          "[collision][analytic]") {
  Fixture smooth;
  const auto ids = rain(smooth, Sphere{0.2}, {.friction = 0.0, .restitution = 0.3}, 40);
  Solver solver({.sleep_after = 0.0});
  for (int i = 0; i < 150; ++i) {
    const StepReport& report = solver.step(smooth.world, kDt);
    REQUIRE(report.turning == 0);
    REQUIRE_FALSE(report.parts.rotation);
    REQUIRE_FALSE(report.parts.friction);
  }
  CHECK(smooth.world.contacts()->contacts().size() > 60);
  for (const BodyId id : ids) {
    CHECK(smooth.world.pose(id).orientation.coeffs() == Quat::Identity().coeffs());
    CHECK(smooth.world.twist(id).angular == Vec3::Zero());
  }
  // Nothing is lost: with a torque far below rounding their rotation is computed, and they move
  // alike. A few only, since rounding grows with each collision.
  Fixture few, turning;
  const auto here = rain(few, Sphere{0.2}, {.friction = 0.0, .restitution = 0.3}, 4);
  const auto there = rain(turning, Sphere{0.2}, {.friction = 0.0, .restitution = 0.3}, 4);
  for (int i = 0; i < 60; ++i) {
    for (const BodyId id : there) turning.world.apply_torque(id, Vec3(1e-30, 0.0, 0.0));
    REQUIRE(solver.step(few.world, kDt).turning == 0);
    REQUIRE(solver.step(turning.world, kDt).turning == 4);
    for (std::size_t k = 0; k < here.size(); ++k) {
      const Vec3 apart = few.world.pose(here[k]).position - turning.world.pose(there[k]).position;
      REQUIRE(apart.norm() < 1e-9);
    }
  }
  // With friction they roll; cubes turn without friction too, since their corners are off centre.
  Fixture rough, cubes;
  rain(rough, Sphere{0.2}, {.friction = 0.5}, 10);
  rain(cubes, Box{Vec3::Constant(0.2)}, {.friction = 0.0}, 10);
  int rough_turning = 0, cubes_turning = 0;
  for (int i = 0; i < 60; ++i) {
    rough_turning = std::max(rough_turning, solver.step(rough.world, kDt).turning);
    cubes_turning = std::max(cubes_turning, solver.step(cubes.world, kDt).turning);
  }
  CHECK(rough_turning >= 9);
  CHECK(cubes_turning >= 9);
}

TEST_CASE("parts: friction and restitution are named where a contact has them",
          "[collision][unit]") {
  struct Case {
    double friction, restitution;
  };
  for (const Case& c : {Case{0.0, 0.0}, Case{0.4, 0.0}, Case{0.0, 0.4}, Case{0.4, 0.4}}) {
    Fixture f;
    rain(f, Sphere{0.2}, {.friction = c.friction, .restitution = c.restitution}, 3);
    Solver solver;
    for (int i = 0; i < 30; ++i) solver.step(f.world, kDt);
    const StepReport& report = solver.step(f.world, kDt);
    REQUIRE(report.parts.contacts);
    CHECK(report.parts.friction == (c.friction > 0.0));
    CHECK(report.parts.restitution == (c.restitution > 0.0));
    CHECK(stages(report) == "detect begin integrate project velocity end");
  }
}

TEST_CASE("parts: targets, and only they, run the displacement channel and the clean-up",
          "[collision][unit]") {
  Fixture f;
  const auto ids = rain(f, Box{Vec3::Constant(0.2)}, {}, 3);
  tandem::testing::FixedTargets targets;
  f.world.set_target_source(&targets);
  Solver solver;
  for (int i = 0; i < 30; ++i) solver.step(f.world, kDt);
  const StepReport& report = solver.step(f.world, kDt);
  CHECK(stages(report) == "detect begin integrate project velocity end");
  CHECK_FALSE(report.parts.targets);
  targets.targets.push_back({.body = ids[1], .pose = at(0.5, 0, 0.2), .share = 0.1});
  solver.step(f.world, kDt);
  CHECK(stages(report) == "detect begin integrate project velocity agree end");
  CHECK(report.parts.targets);
}

TEST_CASE("parts: a scene that sleeps runs nothing once its contacts repeat", "[collision][unit]") {
  Fixture f;
  rain(f, Box{Vec3::Constant(0.2)}, {}, 3);
  Solver solver;
  for (int i = 0; i < 300; ++i) solver.step(f.world, kDt);
  const StepReport& report = solver.step(f.world, kDt);
  REQUIRE(report.awake == 0);
  CHECK(stages(report) == "");
  CHECK(report.turning == 0);
  REQUIRE(report.blocks.size() == 1);
  CHECK(report.blocks[0].rows >= 3);        // they are kept
  CHECK(report.blocks[0].residual < 1e-3);  // and so is how well they hold
  CHECK(report.blocks[0].extra_rows == 0);
  CHECK_FALSE(report.parts.contacts);
}

TEST_CASE("parts: describe() names the stages that ran and those left out", "[collision][unit]") {
  Fixture f;
  rain(f, Box{Vec3::Constant(0.2)}, {.friction = 0.5}, 3);
  Solver solver({.threads = 2});
  for (int i = 0; i < 30; ++i) solver.step(f.world, kDt);
  const std::string text = solver.describe();
  INFO(text);
  CHECK(text.find("stages: detect, begin, integrate, project, velocity, end; "
                  "left out: agree") != std::string::npos);
  CHECK(text.find("parts: contacts, friction, rotation, sleep, refinement; "
                  "left out: restitution, joints, targets") != std::string::npos);
  CHECK(text.find("rows: contact ") != std::string::npos);
  CHECK(text.find("threads 2") != std::string::npos);
}

}  // namespace step_parts_test
