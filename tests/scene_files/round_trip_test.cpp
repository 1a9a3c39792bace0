// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/random.h"
#include "tandem/ragdoll.h"
#include "tandem/scene_files.h"

namespace round_trip_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

constexpr double kStep = 1.0 / 60.0;

Vec3 any_vector(pbd::SplitMix64& random) {
  return {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
}

Quat any_turn(pbd::SplitMix64& random) {
  return Quat(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
              random.uniform(-1.0, 1.0))
      .normalized();
}

std::vector<collision::Shape> solids() {
  // A leaning block with a point inside, and one that is an octahedron.
  const std::vector<Vec3> block{{0.0, 0.0, 0.0},  {0.3, 0.0, 0.0}, {0.0, 0.21, 0.0},
                                {0.1, 0.1, 0.1},  {0.3, 0.2, 0.0}, {0.1, 0.0, 0.3},
                                {0.37, 0.2, 0.3}, {0.1, 0.2, 0.3}};
  const std::vector<Vec3> corners{
      {0.0, 0.0, 0.0}, {0.2, 0.0, 0.0}, {0.0, 0.2, 0.0}, {0.0, 0.0, 0.2}};
  const std::vector<collision::TriangleMesh::Triangle> faces{
      {0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return {Box{0.1, 0.12, 0.15},
          Sphere{0.11},
          Capsule{.radius = 0.07, .half_height = 0.1},
          Cylinder{.radius = 0.1, .half_height = 0.12},
          Cone{.radius = 0.1, .half_height = 0.13},
          collision::ConvexHull::make(block),
          collision::TriangleMesh::make(corners, faces)};
}

/// Ground and a heap of whatever there is, some of it joined in all ways.
Scene heap() {
  pbd::SplitMix64 random(7);
  Scene scene({.gravity = {0.1, 0.0, -9.7}});
  scene.add(HalfSpace{Vec3(0.05, 0.02, 1.0).normalized(), -0.3}, {.type = BodyType::Static});
  const std::vector<double> heights{0.0, 0.1, 0.05, 0.0, 0.2, 0.1, 0.0, 0.0, 0.1};
  scene.add(collision::HeightField::make(3, 3, 1.0, 1.1, heights),
            {.type = BodyType::Static, .pose = {{-1.0, -1.1, -0.3}, any_turn(random)}});
  scene.add(Box{0.4, 0.4, 0.05}, {.type = BodyType::Kinematic,
                                  .pose = {.position = {0.0, 0.0, 0.3}},
                                  .twist = {.angular = {0.0, 0.0, 0.7}},
                                  .stable_id = 99});
  std::vector<BodyId> bodies;
  const std::vector<collision::Shape> shapes = solids();
  for (int i = 0; i < 56; ++i) {
    SolidDef def{.density = random.uniform(100.0, 900.0),
                 .pose = {any_vector(random) + Vec3(0.0, 0.0, 1.6), any_turn(random)},
                 .twist = {any_vector(random), any_vector(random)},
                 .material = {.friction = random.uniform(0.2, 0.9), .restitution = 0.1},
                 .linear_damping = 0.1 * (i % 3),
                 .user_data = static_cast<std::uint64_t>(i)};
    if (i % 5 == 0) def.mass = 1.3;
    if (i % 9 == 0) def.filter = {.category = 2, .mask = ~4u, .group = -3};
    if (i % 11 == 0) def.locks.angular[1] = true;
    def.bullet = i % 13 == 0;
    if (i % 7 == 0) def.sleep_speed = 0.02;
    if (i % 8 == 0) def.sleep_spin = 0.05;
    bodies.push_back(scene.add(shapes[static_cast<std::size_t>(i) % shapes.size()], def));
  }
  const std::vector<collision::CompoundPart> parts{
      {Box{0.2, 0.03, 0.03}, {{0.1, 0.2, 0.3}, any_turn(random)}, 300.0},
      {Sphere{0.08}, {{0.3, 0.2, 0.3}, Quat::Identity()}, 500.0}};
  scene.add(parts, {.pose = {{0.3, 0.2, 2.9}, any_turn(random)}});
  const pbd::World& world = scene.world();
  const auto at = [&](int i) { return world.pose(bodies[static_cast<std::size_t>(i)]).position; };
  auto ball = pbd::ball_joint_at(world, bodies[0], bodies[7], at(0), Vec3::UnitY());
  ball.drive = {.spring = {.frequency = 1.5, .damping_ratio = 0.3, .rest = any_turn(random)},
                .motor = {.mode = pbd::MotorMode::Velocity,
                          .velocity = Vec3(0.3, 0.2, 0.1),
                          .target = any_turn(random),
                          .max_torque = 2.0},
                .friction = 0.1,
                .armature = 0.02};
  scene.add_joint(ball);
  auto swing = pbd::hinge_joint_at(world, bodies[4], bodies[18], at(4), Vec3::UnitY());
  swing.axis.spring = {.rest = 0.2, .frequency = 2.0, .damping_ratio = 0.1};
  swing.axis.friction = 0.05;
  swing.axis.armature = 0.01;
  swing.collide_connected = false;
  scene.add_joint(swing);
  scene.set_apart(bodies[5], bodies[19]);
  auto hinge = pbd::hinge_joint_at(world, {}, bodies[8], at(8), Vec3(1.0, 2.0, 0.5));
  hinge.axis.motor = {.mode = pbd::MotorMode::Velocity, .target = 2.0, .max_force = 3.0};
  scene.add_joint(hinge);
  auto slider = pbd::slider_joint_at(world, bodies[1], bodies[15], at(1), Vec3::UnitZ());
  slider.axis = {.freedom = pbd::Freedom::Limited, .lower = -0.2, .upper = pbd::kUnlimited};
  slider.axis.spring = {.stiffness = 100.0, .rest = 0.1, .damping = 1.0};
  slider.axis.motor = {.mode = pbd::MotorMode::Position,
                       .target = -0.1,
                       .max_force = 4.0,
                       .stiffness = 60.0,
                       .damping = 2.0};
  scene.add_joint(slider);
  auto fixed = pbd::fixed_joint_at(world, bodies[2], bodies[16], at(2));
  fixed.compliance = 1e-4;
  fixed.break_force = 500.0;
  scene.add_joint(fixed);
  auto wheel =
      pbd::wheel_joint_at(world, bodies[3], bodies[17], at(17), Vec3::UnitY(), Vec3::UnitZ());
  wheel.suspension.spring = {.stiffness = 3000.0, .damping = 100.0};
  wheel.drive = {.mode = pbd::MotorMode::Velocity, .target = 5.0, .max_force = 2.0};
  scene.add_joint(wheel);
  // Slots with holes.
  scene.remove(bodies[30]);
  scene.remove(bodies[41]);
  return scene;
}

TEST_CASE("scene files: a written scene reads back with the same bits of motion",
          "[scene_files][determinism]") {
  Scene made = heap();
  const std::string text = write_scene(made);
  if (const char* path = std::getenv("TANDEM_WRITE_SCENE")) std::ofstream(path) << text;
  SceneFile read = parse_scene(text);
  CHECK(read.warnings.empty());
  CHECK(write_scene(read) == text);
  REQUIRE(read.scene.world().body_count() == made.world().body_count());
  const auto first = made.world().hash();
  for (int i = 0; i < 300; ++i) {
    REQUIRE(made.step(kStep).status == pbd::StepStatus::Ok);
    read.scene.step(kStep);
  }
  CHECK(made.world().hash() != first);
  // Slots differ, where some were empty: body by body.
  std::size_t next = 0;
  for (std::uint32_t slot = 0; slot < made.world().slot_count(); ++slot) {
    const BodyId id = made.world().body_at(slot);
    if (!id.valid()) continue;
    const BodyId other = read.bodies[next++].body;
    CAPTURE(slot);
    CHECK(made.world().pose(id).position == read.scene.world().pose(other).position);
    CHECK(made.world().pose(id).orientation.coeffs() ==
          read.scene.world().pose(other).orientation.coeffs());
    CHECK(made.pose(id).position == read.scene.pose(other).position);
    CHECK(made.world().twist(id).linear == read.scene.world().twist(other).linear);
    CHECK(made.world().twist(id).angular == read.scene.world().twist(other).angular);
    CHECK(made.world().user_data(id) == read.scene.world().user_data(other));
  }
  // Written in the middle of its motion, it is where it was.
  CHECK(write_scene(parse_scene(write_scene(made)).scene) == write_scene(made));
}

TEST_CASE("scene files: a hinge is read on the turn that it was written on", "[scene_files]") {
  constexpr double kDegree = std::numbers::pi / 180.0;
  struct Case {
    double lower, upper, at;  // degrees
  };
  for (const Case& c : {Case{170, 190, 181}, {0, 270, 200}, {-720, 720, 400}, {-720, 720, -170}}) {
    CAPTURE(c.lower, c.upper, c.at);
    Scene scene({.gravity = Vec3::Zero()});
    const Quat turn(Eigen::AngleAxisd(c.at * kDegree, Vec3::UnitX()));
    pbd::HingeJointDef def{.b = scene.add(Box{0.1, 0.1, 0.1}, {.pose = {{0, 0, 0}, turn}})};
    def.axis = {
        .freedom = pbd::Freedom::Limited, .lower = c.lower * kDegree, .upper = c.upper * kDegree};
    def.start = c.at * kDegree;
    const pbd::JointId id = scene.add_joint(def);
    // Once as it was added, once after it has moved on.
    for (const double spin : {0.0, 1.0}) {
      scene.world().set_twist(def.b, {.angular = {spin, 0.0, 0.0}});
      for (int i = 0; i < 3; ++i) scene.step(kStep);
      const double angle = scene.joints().hinge_angle(id);
      CHECK(angle == Approx(c.at * kDegree + 3.0 * kStep * spin));
      SceneFile read = parse_scene(write_scene(scene));
      const pbd::JointId other = pbd::joint_ids(read.scene.joints())[0];
      CHECK(read.scene.joints().hinge_angle(other) == Approx(angle).margin(1e-12));
      read.scene.step(kStep);
      scene.step(kStep);
      CHECK(read.scene.joints().hinge_angle(other) ==
            Approx(scene.joints().hinge_angle(id)).margin(1e-12));
      scene.world().set_twist(def.b, {});
    }
  }
}

TEST_CASE("scene files: names are written and read", "[scene_files]") {
  SceneFile file;
  file.bodies = {{"ball \"one\" / ~ \u00e9", file.scene.add(Sphere{0.1})}};
  file.joints = {{"hook", file.scene.add_joint(pbd::ball_joint_at(
                              file.scene.world(), {}, file.bodies[0].body, Vec3::UnitZ()))}};
  SceneFile read = parse_scene(write_scene(file));
  CHECK(read.find("ball \"one\" / ~ \u00e9").valid());
  CHECK(read.scene.joints().contains(read.find_joint("hook")));
  CHECK_FALSE(read.find("hook").valid());
  file.bodies[0].name = "\xff";
  CHECK(names(refusal([&] { write_scene(file); }), "names", "", "UTF-8"));
}

TEST_CASE("scene files: loaded bodies touch bodies made later", "[scene_files]") {
  Scene before({.gravity = Vec3::Zero()});
  Ragdoll(before, {});
  SceneFile file = parse_scene(write_scene(before), {.gravity = Vec3::Zero()});
  Scene& scene = file.scene;
  Ragdoll(scene, {.pose = {.position = {0.05, 0.0, 0.0}}});
  scene.step(kStep);
  const auto loaded = static_cast<std::uint32_t>(file.bodies.size());
  REQUIRE(loaded == Ragdoll::kParts);
  int between = 0;
  for (const pbd::Contact& contact : scene.world().contacts()->contacts()) {
    const auto& m = contact.manifold;
    CHECK((m.body_a < loaded) != (m.body_b < loaded));  // no limb meets those of its own body
    ++between;
  }
  CHECK(between >= 11);
}

TEST_CASE("scene files: rows that they cannot hold are not dropped", "[scene_files]") {
  Scene scene;
  const BodyId ball = scene.add(Sphere{0.1});
  auto& ropes = scene.world().add_block<pbd::DistanceJoints>();
  CHECK(refusal([&] { write_scene(scene); }).empty());  // a block without rows is none
  ropes.add(scene.world(), {.b = ball, .rest_length = 1.0});
  CHECK(names(refusal([&] { write_scene(scene); }), "rows", "distance_joint", "joints"));
}

}  // namespace round_trip_test
