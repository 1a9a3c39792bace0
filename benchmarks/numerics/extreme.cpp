// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Extreme conditions: very long and short steps, far from the origin, very fast spin, thin rods.
#include <algorithm>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

void add_pendulum(Scene& scene, const Vec3& nail) {
  const Quat q = pbd::exp_map(Vec3(0.0, 0.5, 0.0));
  const int bob = scene.add(SphereShape{0.1}, 1.0,
                            {.position = nail + q * Vec3(0.0, 0.0, -1.0), .orientation = q});
  scene.bodies.back().collides = false;
  scene.add_ball(-1, bob, nail);
}

/// Five cubes and a pendulum, at steps of this length.
void step_length(Sheet& sheet, double dt) {
  Scene scene;
  scene.dt = dt;
  scene.add_static(PlaneShape{});
  for (int k = 0; k < 5; ++k) scene.add(cube(1.0), 100.0, at(0.0, 0.0, 0.5 + k));
  add_pendulum(scene, Vec3(5.0, 0.0, 3.0));
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, 0.5));
  double speed = 0.0;
  double separation = 0.0;
  run_scene(scene, *engine, [&](double t) {
    energy.after_frame(*engine);
    separation = std::max(separation, joint_separation(scene, *engine));
    if (t > scene.seconds - 1.0) {
      speed = std::max(speed, engine->state(5).twist.linear.norm());
    }
  });
  const Vec3 moved = engine->state(5).pose.position - scene.bodies[5].pose.position;
  sheet.at_most("drift of the top cube", 1e3 * moved.norm(), 5.0, "mm", "stands");
  sheet.at_most("its speed in the last second", speed, 1e-2, "m/s", "at rest");
  sheet.at_most("separation of the pendulum", 1e3 * separation, 1.0, "mm", "joints hold");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

/// A stack that settles, a box that slides to rest, and a pendulum.
Scene common_scene(const Vec3& origin) {
  Scene scene;
  scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, {.position = origin - Vec3(0.0, 0.0, 1.0)});
  for (int k = 0; k < 5; ++k) {
    scene.add(cube(1.0), 100.0, {.position = origin + Vec3(0.01 * (k % 2), 0.0, 0.501 + k)});
  }
  scene.add(cube(1.0), 100.0, {.position = origin + Vec3(4.0, 0.0, 0.5)});
  scene.bodies.back().twist.linear = Vec3(3.0, 1.0, 0.0);
  add_pendulum(scene, origin + Vec3(0.0, 8.0, 5.0));
  return scene;
}

void far_away(Sheet& sheet) {
  const Vec3 offset(1e5, 1e5, 0.0);
  const Scene near = common_scene(Vec3::Zero());
  const Scene far = common_scene(offset);
  const auto engine_near = sheet.make(near);
  const auto engine_far = sheet.make(far);
  double worst = 0.0;
  run_scene(near, *engine_near, [&](double) {
    engine_far->step(far.dt);
    for (int i = 1; i < static_cast<int>(near.bodies.size()); ++i) {
      const Vec3 difference =
          engine_far->state(i).pose.position - offset - engine_near->state(i).pose.position;
      worst = std::max(worst, difference.norm());
    }
  });
  sheet.at_most("largest difference", worst, 1e-6, "m", "the same scene at the origin");
}

void very_fast_spin(Sheet& sheet) {
  Scene scene;
  scene.gravity = Vec3::Zero();
  const int box = scene.add(BoxShape{Vec3(0.1, 0.2, 0.3)}, 1.0, {});
  scene.bodies.back().twist.angular = Vec3(1e4, 3e3, 0.0);
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, 0.0);
  double moved = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    moved = std::max(moved, engine->state(box).pose.position.norm());
  });
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
  sheet.at_most("way of the centre", moved, 1e-9, "m", "no force");
}

/// A ball that spins on the floor at 1e4 rad/s about a horizontal axis.
void spin_on_floor(Sheet& sheet) {
  Scene scene;
  scene.add_static(PlaneShape{});
  const int ball = scene.add(SphereShape{0.1}, 1.0, at(0.0, 0.0, 0.1));
  scene.bodies.back().twist.angular = Vec3(0.0, 1e4, 0.0);
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, 0.1));
  double height = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    height = std::max(height, engine->state(ball).pose.position.z() - 0.1);
  });
  // Friction is the only force: mu g t after 10 s.
  sheet.relative("speed after 10 s, m/s", engine->state(ball).twist.linear.norm(),
                 0.5 * kGravity * 10.0, 0.01, "mu g t");
  sheet.at_most("height over the floor", height, 1e-3, "m", "no force upwards");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

/// Ten metres long, one centimetre wide: falls and comes to rest.
void thin_rod(Sheet& sheet) {
  Scene scene;
  scene.add_static(PlaneShape{});
  const Quat q = pbd::exp_map(Vec3(0.0, 0.6, 0.2));
  const int rod = scene.add(BoxShape{Vec3(5.0, 0.005, 0.005)}, 1.0,
                            {.position = Vec3(0.0, 0.0, 4.0), .orientation = q});
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, 0.0);
  double deepest = 0.0;
  double speed = 0.0;
  run_scene(scene, *engine, [&](double t) {
    energy.after_frame(*engine);
    const pbd::BodyState s = engine->state(rod);
    if (t <= scene.seconds - 1.0) return;
    for (const double x : {-5.0, 5.0}) {
      deepest = std::max(deepest, 0.005 - s.pose.to_world(Vec3(x, 0.0, 0.0)).z());
    }
    speed = std::max(speed, s.twist.linear.norm());
  });
  sheet.at_most("overlap in the last second", 1e3 * deepest, 1.0, "mm", "lies on the floor");
  sheet.at_most("speed in the last second", speed, 1e-2, "m/s", "at rest");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

}  // namespace

std::vector<Case> extreme_cases() {
  const std::string family = "extreme";
  std::vector<Case> cases;
  for (const char* const ms : {"1", "4", "33", "100"}) {
    const double dt = 1e-3 * std::stod(ms);
    cases.push_back(
        {family, std::string("steps of ") + ms + " ms", [dt](Sheet& s) { step_length(s, dt); }});
  }
  cases.push_back({family, "1e5 m from the origin", far_away});
  cases.push_back({family, "free spin, 1e4 rad/s", very_fast_spin});
  cases.push_back({family, "ball on the floor, 1e4 rad/s", spin_on_floor});
  cases.push_back({family, "rod of 1000:1", thin_rod});
  return cases;
}

}  // namespace tandem::bench
