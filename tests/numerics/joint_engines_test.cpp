// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Each engine is given the joints that were meant: limits, friction, motors, and which bodies
// touch. Engines whose adapter refuses a scene are left out of it. Bounds are those of engines in
// single precision with soft stops.
#include <algorithm>

#include "numerics/track.h"
#include "support/catch.h"
#include "taking_engines.h"

namespace joint_engines_test {

using namespace tandem::bench;

namespace {

/// A ball on a joint to the world through its middle, without weight, turning at `spin` rad/s.
Scene spinner(JointKind kind, const Vec3& axis, const Vec3& spin) {
  Scene scene;
  scene.gravity = Vec3::Zero();
  const int ball = scene.add(SphereShape{0.5}, 10.0, at(0.0, 0.0, 0.0));
  scene.bodies.back().twist.angular = spin;
  scene.add_joint(kind, -1, ball, Vec3::Zero()).axis_w = axis;
  return scene;
}

/// rad, about `axis`, of the first body against its start, within half a turn.
double turn(const Engine& engine, const Vec3& axis) {
  return tandem::pbd::log_map(engine.state(0).pose.orientation).dot(axis);
}

const Vec3 kAxis = Vec3(0.6, 0.0, 0.8);
constexpr double kInertia = 0.4 * 10.0 * 0.25;  // kg m^2, of the spinner

}  // namespace

TEST_CASE("engines: limits of hinge and twist stop where they are, to either side",
          "[numerics][engines]") {
  for (const JointKind kind : {JointKind::Hinge, JointKind::Ball}) {
    for (const double sign : {1.0, -1.0}) {
      INFO((kind == JointKind::Hinge ? "hinge" : "twist") << ", sign " << sign);
      Scene scene = spinner(kind, kAxis, sign * 2.0 * kAxis);
      scene.joints[0].limited = true;
      scene.joints[0].lower = -0.3;
      scene.joints[0].upper = 0.7;
      for_each_engine(scene, [&](Engine& engine) {
        double least = 0.0;
        double most = 0.0;
        run_scene(scene, engine, [&](double) {
          least = std::min(least, turn(engine, kAxis));
          most = std::max(most, turn(engine, kAxis));
        });
        CHECK((sign > 0.0 ? most : -least) == Approx(sign > 0.0 ? 0.7 : 0.3).margin(0.02));
      });
    }
  }
}

TEST_CASE("engines: a cone stops the swing of its axis", "[numerics][engines]") {
  const Vec3 across = Vec3::UnitY();
  Scene scene = spinner(JointKind::Ball, kAxis, 2.0 * across);
  scene.seconds = 1.0;
  scene.joints[0].cone = 0.5;
  for_each_engine(scene, [&](Engine& engine) {
    double most = 0.0;
    run_scene(scene, engine, [&](double) { most = std::max(most, turn(engine, across)); });
    CHECK(most == Approx(0.5).margin(0.02));
  });
}

TEST_CASE("engines: joint friction brakes by its torque", "[numerics][engines]") {
  constexpr double kTorque = 3.0;
  constexpr double kSpin = 4.0;
  for (const JointKind kind : {JointKind::Hinge, JointKind::Ball}) {
    INFO((kind == JointKind::Hinge ? "hinge" : "ball"));
    Scene scene = spinner(kind, kAxis, kSpin * kAxis);
    scene.seconds = 1.0;
    scene.joints[0].friction = kTorque;
    for_each_engine(scene, [&](Engine& engine) {
      run_scene(scene, engine);
      CHECK(engine.state(0).twist.angular.dot(kAxis) ==
            Approx(kSpin - kTorque / kInertia).epsilon(0.02));
    });
  }
}

TEST_CASE("engines: a motor has no more than its torque, and keeps its speed",
          "[numerics][engines]") {
  constexpr double kTorque = 3.0;
  for (const double sign : {1.0, -1.0}) {
    Scene scene = spinner(JointKind::Hinge, kAxis, Vec3::Zero());
    scene.seconds = 1.0;
    scene.joints[0].driven = true;
    scene.joints[0].speed = 4.0 * sign;
    scene.joints[0].max_torque = kTorque;
    for_each_engine(scene, [&](Engine& engine) {
      const auto spin = [&] { return sign * engine.state(0).twist.angular.dot(kAxis); };
      run_scene(scene, engine);
      CHECK(spin() == Approx(kTorque / kInertia).epsilon(0.02));
      run_scene(scene, engine);
      CHECK(spin() == Approx(4.0).epsilon(0.02));
    });
  }
}

TEST_CASE("engines: bodies are kept apart where a joint or the scene says so",
          "[numerics][engines]") {
  // Two balls, half in each other: on a joint, apart otherwise, or neither.
  for (const int how : {0, 1, 2}) {
    INFO(how);
    Scene scene;
    scene.gravity = Vec3::Zero();
    scene.seconds = 2.0;
    scene.add(SphereShape{0.5}, 1.0, at(0.0, 0.0, 0.0));
    scene.add(SphereShape{0.5}, 1.0, at(0.5, 0.0, 0.0));
    if (how == 0) scene.add_joint(JointKind::Hinge, 0, 1, Vec3(2.0, 0.0, 0.0)).touch = false;
    if (how == 1) scene.apart.emplace_back(0, 1);
    for_each_engine(scene, [&](Engine& engine) {
      run_scene(scene, engine);
      const double way =
          (engine.state(1).pose.position - engine.state(0).pose.position).norm() - 0.5;
      if (how == 2) {
        CHECK(way > 0.3);
      } else {
        CHECK(way == Approx(0.0).margin(1e-4));
      }
    });
  }
}

}  // namespace joint_engines_test
