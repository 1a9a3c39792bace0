// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <numbers>

#include "scenes.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/math.h"

/// Overlaps of bodies that joints hold open without velocity, or stay.
namespace joint_overlap_test {

using namespace tandem::collision;
using namespace tandem::pbd;
using tandem::testing::weightless;

constexpr double kDegree = std::numbers::pi / 180.0;

Mat3 inertia_of(double mass, const Capsule& shape) {
  const double length = 2.0 * shape.half_height;
  const double across = mass * (length * length / 12.0 + shape.radius * shape.radius / 4.0);
  return Vec3(across, across, 0.5 * mass * shape.radius * shape.radius).asDiagonal();
}

TEST_CASE("joint: limbs on ball joints that overlap at first get no speed from it",
          "[collision][joint]") {
  struct Case {
    double overlap, cone, friction;  // m, rad, N m
  };
  const auto [overlap, cone, friction] =
      GENERATE(Case{0.04, 2.0 * kDegree, 5.0}, Case{0.01, 2.0 * kDegree, 0.0},
               Case{0.04, 10.0 * kDegree, 0.0}, Case{0.04, 30.0 * kDegree, 0.0},
               Case{0.04, kUnlimited, 0.0}, Case{0.05, 5.0 * kDegree, 0.0});
  INFO("overlap " << overlap << " m, cone " << cone << ", friction " << friction << " N m");
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  world.add_block<ContactBlock>();
  CollisionScene scene;
  world.set_contact_source(&scene);
  BodyDef torso;
  torso.mass = 10.0;
  torso.inertia = 0.2 * Mat3::Identity();
  const BodyId hip = world.add_body(torso);
  const Capsule shape{.radius = 0.1, .half_height = 0.25};
  for (const double side : {-1.0, 1.0}) {
    const double x = side * (shape.radius - 0.5 * overlap);
    BodyDef limb;
    limb.mass = 13.6;
    limb.inertia = inertia_of(limb.mass, shape);
    limb.pose.position = Vec3(x, 0.0, -0.35);
    const BodyId body = world.add_body(limb);
    scene.add(world, {.body = body, .shape = shape});
    SixDofJointDef def = six_dof_joint_at(world, hip, body, Vec3(x, 0.0, 0.0), -Vec3::UnitZ());
    for (JointAxis& axis : def.linear) axis.freedom = Freedom::Locked;
    def.cone = cone;
    if (friction > 0.0) {
      for (JointAxis& axis : def.angular)
        axis.motor = {.mode = MotorMode::Velocity, .target = 0.0, .max_force = friction};
    }
    joints.add(world, def);
  }
  Solver solver({.sleep_after = 0.0});
  double most = 0.0;  // J
  for (int i = 0; i < 300; ++i) {
    CHECK(solver.step(world, 1.0 / 60.0).status == StepStatus::Ok);
    most = std::max(most, world.kinetic_energy());
  }
  // The part that closes with velocity, 2 mm at 20/s, is 0.04 m/s.
  CHECK(most < 0.5 * 37.2 * 0.04 * 0.04);
}

TEST_CASE("joint: an arm held in a table by its hinge lies still", "[collision][joint]") {
  const double overlap = GENERATE(0.005, 0.02, 0.03);
  World world;
  auto& joints = world.add_block<JointBlock>();
  world.add_block<ContactBlock>();
  CollisionScene scene;
  world.set_contact_source(&scene);
  const BodyId table =
      world.add_body({.type = BodyType::Static, .pose = {Vec3(0.0, 0.0, 0.5), Quat::Identity()}});
  scene.add(world, {.body = table, .shape = Box{Vec3(0.4, 0.4, 0.5)}});
  const Capsule shape{.radius = 0.05, .half_height = 0.25};
  const double z = 1.05 - overlap;
  BodyDef def;
  def.inertia = inertia_of(def.mass, shape);
  def.pose = {Vec3(0.25, 0.0, z), Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitX())};
  const BodyId arm = world.add_body(def);
  scene.add(world, {.body = arm, .shape = shape});
  joints.add(world, hinge_joint_at(world, {}, arm, Vec3(0.0, 0.0, z), Vec3::UnitY()));
  Solver solver;
  double most = 0.0;  // J
  for (int i = 0; i < 300; ++i) {
    CHECK(solver.step(world, 1.0 / 60.0).status == StepStatus::Ok);
    most = std::max(most, world.kinetic_energy());
  }
  CHECK(most < 1e-3);
}

}  // namespace joint_overlap_test
