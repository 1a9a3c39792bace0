// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts under extreme conditions: bullets and thin walls, 1 mm beside 100 m, overlap at the
// start.
#include <algorithm>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

/// Shots at a wall of 1 cm, from distances that make the step end before, in and behind it.
void thin_wall(Sheet& sheet, const SceneShape& shape) {
  constexpr int kShots = 20;
  int through = 0;
  for (int i = 0; i < kShots; ++i) {
    Scene scene;
    scene.gravity = Vec3::Zero();
    scene.seconds = 1.0;
    scene.add_static(BoxShape{Vec3(0.005, 5.0, 5.0)});
    const int shot = scene.add(shape, 1.0, at(-5.0 - 1000.0 / 60.0 * i / kShots, 0.1, 0.2));
    scene.bodies.back().twist.linear = Vec3(1000.0, 0.0, 0.0);
    const auto engine = sheet.make(scene);
    bool beyond = false;
    run_scene(scene, *engine,
              [&](double) { beyond |= !(engine->state(shot).pose.position.x() < 0.0); });
    through += beyond ? 1 : 0;
  }
  sheet.at_most("through the wall, of 20 shots", through, 0.0, "", "solid");
}

/// A stack of three 1 mm cubes on a cube of 100 m, and one beside it on the ground.
void sizes(Sheet& sheet) {
  constexpr double kSmall = 1e-3;
  constexpr double kLarge = 100.0;
  constexpr double kDensity = 1000.0;
  Scene scene;
  scene.add_static(PlaneShape{});
  scene.add(cube(kLarge), kDensity * kLarge * kLarge * kLarge, at(0.0, 0.0, 0.5 * kLarge));
  const double mass = kDensity * kSmall * kSmall * kSmall;
  for (int k = 0; k < 3; ++k)
    scene.add(cube(kSmall), mass, at(1.0, 2.0, kLarge + (k + 0.5) * kSmall));
  scene.add(cube(kSmall), mass, at(60.0, 0.0, 0.5 * kSmall));
  const auto engine = sheet.make(scene);
  double speed = 0.0;
  run_scene(scene, *engine, [&](double t) {
    if (t <= scene.seconds - 1.0) return;
    for (int i = 1; i < static_cast<int>(scene.bodies.size()); ++i) {
      speed = std::max(speed, engine->state(i).twist.linear.norm());
    }
  });
  double worst = 0.0;
  for (int i = 2; i < static_cast<int>(scene.bodies.size()); ++i) {
    // Relative to the support: the large cube's top, or the ground.
    const double base = i < 5 ? engine->state(1).pose.position.z() - 0.5 * kLarge : 0.0;
    const Vec3 moved = engine->state(i).pose.position -
                       scene.bodies[static_cast<std::size_t>(i)].pose.position -
                       Vec3(0.0, 0.0, base);
    worst = std::max(worst, moved.norm());
  }
  sheet.at_most("drift of a small cube", 1e3 * worst, 0.1, "mm", "a tenth of its size");
  sheet.at_most("speed in the last second", speed, 1e-3, "m/s", "at rest");
}

/// Two 1 m cubes on the floor with centres `distance` apart at the start.
void overlap(Sheet& sheet, double distance) {
  Scene scene;
  scene.add_static(PlaneShape{});
  scene.add(cube(1.0), 100.0, at(0.0, 0.0, 0.5));
  scene.add(cube(1.0), 100.0, at(distance, 0.0, 0.5));
  const auto engine = sheet.make(scene);
  double speed = 0.0;
  run_scene(scene, *engine, [&](double) {
    for (const int i : {1, 2}) speed = std::max(speed, engine->state(i).twist.linear.norm());
  });
  PenetrationProbe probe(scene);
  sheet.at_most("largest speed", speed, 1.0, "m/s", "pushed apart gently");
  sheet.at_most("overlap after 10 s", 1e3 * probe.measure(*engine).max, 10.0, "mm", "apart");
}

}  // namespace

std::vector<Case> extreme_contact_cases() {
  const std::string family = "extreme";
  return {
      {family, "ball of 10 cm, 1000 m/s, wall of 1 cm",
       [](Sheet& s) { thin_wall(s, SphereShape{0.05}); }},
      {family, "cube of 10 cm, 1000 m/s, wall of 1 cm", [](Sheet& s) { thin_wall(s, cube(0.1)); }},
      {family, "ball of 1 cm, 1000 m/s, wall of 1 cm",
       [](Sheet& s) { thin_wall(s, SphereShape{0.005}); }},
      {family, "1 mm and 100 m in one scene", sizes},
      {family, "0.3 m of overlap at the start", [](Sheet& s) { overlap(s, 0.7); }},
      {family, "complete overlap at the start", [](Sheet& s) { overlap(s, 0.0); }},
  };
}

}  // namespace tandem::bench
