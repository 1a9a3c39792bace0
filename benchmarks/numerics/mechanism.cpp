// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Hinges, sliders, limits and motors: a slider-crank, and a motor that drives against a stop.
#include <algorithm>
#include <numbers>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

/// Rotation (rad) of the body's x axis about the world's -y axis: from x towards z.
double angle_of(const Engine& engine, int body) {
  const Vec3 x = engine.state(body).pose.orientation * Vec3::UnitX();
  return std::atan2(x.z(), x.x());
}

/// Adds a bar in the plane y = 0 with ends `from` and `to`.
int add_bar(Scene& scene, const Vec3& from, const Vec3& to, double mass) {
  const Vec3 along = to - from;
  const double angle = std::atan2(along.z(), along.x());
  const int bar = scene.add(
      BoxShape{Vec3(0.5 * along.norm(), 0.02, 0.02)}, mass,
      {.position = 0.5 * (from + to), .orientation = pbd::exp_map(Vec3(0.0, -angle, 0.0))});
  scene.bodies.back().collides = false;
  return bar;
}

/// A crank of 0.3 m turns once per second and drives a block along x by a rod of 1 m.
void slider_crank(Sheet& sheet) {
  constexpr double kCrank = 0.3;
  constexpr double kRod = 1.0;
  constexpr double kStart = 0.8;  // rad
  Scene scene;
  const Vec3 pin = kCrank * Vec3(std::cos(kStart), 0.0, std::sin(kStart));
  const Vec3 end(pin.x() + std::sqrt(kRod * kRod - pin.z() * pin.z()), 0.0, 0.0);
  const int crank = add_bar(scene, Vec3::Zero(), pin, 1.0);
  const int rod = add_bar(scene, pin, end, 1.0);
  const int block = scene.add(cube(0.1), 2.0, {.position = end});
  scene.bodies.back().collides = false;
  SceneJoint& motor = scene.add_joint(JointKind::Hinge, -1, crank, Vec3::Zero());
  motor.axis_w = -Vec3::UnitY();
  motor.driven = true;
  motor.speed = 2.0 * std::numbers::pi;
  scene.add_joint(JointKind::Hinge, crank, rod, pin).axis_w = -Vec3::UnitY();
  scene.add_joint(JointKind::Hinge, rod, block, end).axis_w = -Vec3::UnitY();
  scene.add_joint(JointKind::Slider, -1, block, end).axis_w = Vec3::UnitX();
  const auto engine = sheet.make(scene);
  double closure = 0.0;
  double separation = 0.0;
  double off_axis = 0.0;
  double turned = 0.0;
  double last = kStart;
  run_scene(scene, *engine, [&](double) {
    const double angle = angle_of(*engine, crank);
    turned += std::abs(std::remainder(angle - last, 2.0 * std::numbers::pi));
    last = angle;
    const Vec3 p = engine->state(block).pose.position;
    const double sine = kCrank * std::sin(angle);
    const double expected = kCrank * std::cos(angle) + std::sqrt(kRod * kRod - sine * sine);
    const double error = std::abs(p.x() - expected);
    closure = std::isnan(error) ? HUGE_VAL : std::max(closure, error);
    off_axis = std::max(off_axis, std::hypot(p.y(), p.z()));
    separation = std::max(separation, joint_separation(scene, *engine));
  });
  sheet.at_most("block against the crank's angle", closure, 1e-6, "m", "closed form");
  sheet.at_most("hinges apart", separation, 1e-6, "m", "joints hold");
  sheet.at_most("block off its line", off_axis, 1e-6, "m", "joints hold");
  sheet.relative("turns in 10 s", turned / (2.0 * std::numbers::pi), 10.0, 0.01, "motor");
}

/// An arm of 1 m, driven at 10 rad/s with unlimited torque against a stop at 0.5 rad.
void motor_against_limit(Sheet& sheet) {
  constexpr double kLimit = 0.5;
  Scene scene;
  const int arm = add_bar(scene, Vec3::Zero(), Vec3(1.0, 0.0, 0.0), 1.0);
  SceneJoint& hinge = scene.add_joint(JointKind::Hinge, -1, arm, Vec3::Zero());
  hinge.axis_w = -Vec3::UnitY();
  hinge.limited = true;
  hinge.lower = -kLimit;
  hinge.upper = kLimit;
  hinge.driven = true;
  hinge.speed = 10.0;
  const auto engine = sheet.make(scene);
  double beyond = 0.0;
  double speed = 0.0;
  double least = HUGE_VAL;
  run_scene(scene, *engine, [&](double t) {
    const double angle = std::abs(angle_of(*engine, arm));
    beyond = std::isnan(angle) ? HUGE_VAL : std::max(beyond, angle - kLimit);
    if (t <= scene.seconds - 1.0) return;
    least = std::min(least, angle);
    speed = std::max(speed, engine->state(arm).twist.angular.norm());
  });
  sheet.at_most("angle beyond the stop", beyond, 0.01, "rad", "limit holds");
  sheet.at_most("angle short of it in the last second", kLimit - least, 0.01, "rad", "motor holds");
  sheet.at_most("speed in the last second", speed, 1e-2, "rad/s", "at rest");
}

}  // namespace

std::vector<Case> mechanism_cases() {
  return {{"analytic", "slider-crank", slider_crank},
          {"stiff", "motor of unlimited torque against a limit", motor_against_limit}};
}

}  // namespace tandem::bench
