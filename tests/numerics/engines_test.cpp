// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Every engine that this build has is given the scene that was meant: gravity, mass, inertia,
// friction, shapes and joints all leave their mark on a motion with a closed form. Bounds are wide,
// for engines in single precision with 20 mm of slop: an adapter that gets something wrong misses
// them by far.
#include "peers/engines.h"

#include <numbers>

#include "numerics/case.h"
#include "numerics/track.h"
#include "support/catch.h"

namespace engines_test {

using namespace tandem::bench;

namespace {

/// Runs `check(make)` for each engine, under its name.
template <class F>
void for_each_engine(const F& check) {
  for (const auto& [name, make] : built_engines()) {
    INFO(name);
    check(make);
  }
}

/// Down a slope of this tangent, along +x.
struct Slope {
  explicit Slope(double tangent)
      : angle(std::atan(tangent)),
        turn(tandem::pbd::exp_map(Vec3(0.0, angle, 0.0))),
        normal(turn * Vec3::UnitZ()),
        down(turn * Vec3::UnitX()) {}
  double angle;
  Quat turn;
  Vec3 normal, down;
};

/// m/s^2 that body 1 gains along the slope, over the second half of the run.
double acceleration(const Scene& scene, Engine& engine, const Vec3& down) {
  double half = 0.0;
  run_scene(scene, engine, [&](double t) {
    if (t < 0.5 * scene.seconds + 0.5 * scene.dt) half = engine.state(1).twist.linear.dot(down);
  });
  return (engine.state(1).twist.linear.dot(down) - half) / (0.5 * scene.seconds);
}

/// A flat floor of two triangles, of which one may only be met from above.
MeshShape floor_mesh() {
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices = {{-5.0, -5.0, 0.0}, {5.0, -5.0, 0.0}, {5.0, 5.0, 0.0}, {-5.0, 5.0, 0.0}};
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace

TEST_CASE("engines: a thrown ball flies as the difference equation says", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    Scene scene;
    scene.seconds = 2.0;
    const Vec3 velocity(3.0, 1.0, 4.0);
    const int ball = scene.add(SphereShape{0.1}, 2.0, at(0.0, 0.0, 10.0));
    scene.bodies.back().twist.linear = velocity;
    const auto engine = make(scene, {});
    run_scene(scene, *engine);
    const int n = scene.frames() * engine->stats().substeps;
    const double h = scene.seconds / n;
    const Vec3 expected =
        Vec3(0.0, 0.0, 10.0) + scene.seconds * velocity + 0.5 * h * h * n * (n + 1) * scene.gravity;
    const tandem::pbd::BodyState end = engine->state(ball);
    CHECK((end.pose.position - expected).norm() < 1e-4);
    CHECK((end.twist.linear - velocity - scene.seconds * scene.gravity).norm() < 1e-4);
  });
}

TEST_CASE("engines: a box slides by the friction that it was given", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    const Slope slope(0.5);
    constexpr double kFriction = 0.3;
    Scene scene;
    scene.seconds = 2.0;
    scene.add_static(PlaneShape{slope.normal, 0.3});
    scene.add(cube(1.0), 10.0, {.position = 0.8 * slope.normal, .orientation = slope.turn});
    for (SceneBody& body : scene.bodies) body.friction = kFriction;
    const auto engine = make(scene, {});
    const double expected = kGravity * (std::sin(slope.angle) - kFriction * std::cos(slope.angle));
    CHECK(acceleration(scene, *engine, slope.down) == Approx(expected).epsilon(0.02));
    CHECK(engine->state(1).pose.position.dot(slope.normal) == Approx(0.8).margin(0.025));
  });
}

TEST_CASE("engines: a ball rolls with the inertia that it was given", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    const Slope slope(0.2);
    for (const double inertia : {0.4, 0.8}) {  // solid; as if its mass lay outside
      Scene scene;
      scene.seconds = 2.0;
      scene.add_static(PlaneShape{slope.normal, 0.0});
      scene.add(SphereShape{0.5}, 2.0, {.position = 0.5 * slope.normal});
      scene.bodies.back().inertia = Vec3::Constant(inertia * 2.0 * 0.25);
      const auto engine = make(scene, {});
      CHECK(acceleration(scene, *engine, slope.down) ==
            Approx(kGravity * std::sin(slope.angle) / (1.0 + inertia)).epsilon(0.02));
    }
  });
}

TEST_CASE("engines: each shape rests as high as it is thick", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    const Quat lying = tandem::pbd::exp_map(Vec3(0.0, 0.5 * std::numbers::pi, 0.0));
    for (const bool mesh : {false, true}) {
      INFO((mesh ? "on a mesh" : "on a box"));
      Scene scene;
      scene.seconds = 2.0;
      if (mesh) {
        scene.add_static(floor_mesh());
      } else {
        scene.add_static(BoxShape{Vec3(5.0, 5.0, 1.0)}, at(0.0, 0.0, -1.0));
      }
      const int box = scene.add(BoxShape{Vec3(0.5, 0.4, 0.3)}, 5.0, at(-2.0, -1.0, 0.35));
      const int ball = scene.add(SphereShape{0.2}, 5.0, at(0.0, -1.0, 0.25));
      const int capsule = scene.add(CapsuleShape{0.25, 0.5}, 5.0,
                                    {.position = Vec3(2.0, -1.0, 0.3), .orientation = lying});
      const int ghost = scene.add(SphereShape{0.2}, 5.0, at(0.0, 2.0, 0.5));
      scene.bodies.back().collides = false;
      const auto engine = make(scene, {});
      run_scene(scene, *engine);
      CHECK(engine->state(box).pose.position.z() == Approx(0.3).margin(0.025));
      CHECK(engine->state(ball).pose.position.z() == Approx(0.2).margin(0.025));
      CHECK(engine->state(capsule).pose.position.z() == Approx(0.25).margin(0.025));
      CHECK(engine->state(ghost).pose.position.z() < -10.0);
    }
  });
}

TEST_CASE("engines: a ball bounces with the restitution that it was given", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    Scene scene;
    scene.seconds = 1.0;
    scene.add_static(BoxShape{Vec3(5.0, 5.0, 1.0)}, at(0.0, 0.0, -1.0));
    const int ball = scene.add(SphereShape{0.1}, 1.0, at(0.0, 0.0, 1.1));
    for (SceneBody& body : scene.bodies) body.restitution = 0.5;
    const auto engine = make(scene, {});
    double fastest = 0.0;
    run_scene(scene, *engine,
              [&](double) { fastest = std::max(fastest, engine->state(ball).twist.linear.z()); });
    // Bullet pushes out what overlaps besides, which makes it 16 % faster.
    CHECK(fastest == Approx(0.5 * std::sqrt(2.0 * kGravity)).epsilon(0.2));
  });
}

TEST_CASE("engines: a rod on a ball joint swings with its period", "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    constexpr double kHalf = 0.5;  // m, of the rod
    Scene scene;
    scene.seconds = 5.0;
    const Quat tilt = tandem::pbd::exp_map(Vec3(0.0, 0.1, 0.0));
    const int rod = scene.add(BoxShape{Vec3(0.05, 0.05, kHalf)}, 3.0,
                              {.position = tilt * Vec3(0.0, 0.0, -kHalf), .orientation = tilt});
    scene.add_ball(-1, rod, Vec3::Zero());
    scene.bodies.back().collides = false;
    const auto engine = make(scene, {});
    std::vector<double> x;
    run_scene(scene, *engine, [&](double) { x.push_back(engine->state(rod).pose.position.x()); });
    const double about_joint = scene.bodies[0].inertia.y() + 3.0 * kHalf * kHalf;
    CHECK(crossing_period(x, scene.dt) ==
          Approx(2.0 * std::numbers::pi * std::sqrt(about_joint / (3.0 * kGravity * kHalf)))
              .epsilon(0.01));
    CHECK(joint_separation(scene, *engine) < 0.01);
  });
}

TEST_CASE("engines: a body goes where it is put, at the velocity it is given",
          "[numerics][engines]") {
  for_each_engine([](const MakeEngine& make) {
    Scene scene;
    scene.gravity = Vec3::Zero();
    const int box = scene.add(cube(1.0), 1.0, at(0.0, 0.0, 0.0));
    const auto engine = make(scene, {});
    engine->step(scene.dt);
    const Quat turned = tandem::pbd::exp_map(Vec3(0.3, 0.2, 0.1));
    engine->set_pose(box, {.position = Vec3(1.0, 2.0, 3.0), .orientation = turned});
    engine->set_twist(box, {.linear = Vec3(0.6, 0.0, -1.2), .angular = Vec3(0.0, 0.0, 0.6)});
    engine->step(scene.dt);
    const tandem::pbd::BodyState end = engine->state(box);
    CHECK((end.pose.position - Vec3(1.01, 2.0, 2.98)).norm() < 1e-4);
    CHECK((tandem::pbd::exp_map(Vec3(0.0, 0.0, 0.01)) * turned)
              .angularDistance(end.pose.orientation) < 1e-3);
  });
}

}  // namespace engines_test
