// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Hard scenes for a solver: mass ratios, long chains, high stacks, contradictions.
#include <algorithm>
#include <numbers>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

constexpr double kLink = 0.2;  // m

struct Chain {
  int links;
  double end_mass;  ///< kg; a link has 1 kg
  double angle;     ///< rad from the vertical: below a right angle it stays taut
  double compliance = 0.0;
};

/// A straight chain with a ball at its end, released at an angle.
Scene chain_scene(const Chain& chain) {
  constexpr double kRadius = 0.05;
  Scene scene;
  const Quat q = pbd::exp_map(Vec3(0.0, 0.5 * std::numbers::pi - chain.angle, 0.0));
  const Vec3 along = q * Vec3::UnitX();
  for (int i = 0; i < chain.links; ++i) {
    const int link = scene.add(BoxShape{Vec3(0.5 * kLink, 0.025, 0.025)}, 1.0,
                               {.position = (i + 0.5) * kLink * along, .orientation = q});
    scene.add_ball(link - 1, link, i * kLink * along);
  }
  const double length = chain.links * kLink;
  const int ball = scene.add(SphereShape{kRadius}, chain.end_mass,
                             {.position = (length + kRadius) * along, .orientation = q});
  scene.add_ball(ball - 1, ball, length * along);
  for (SceneBody& body : scene.bodies) body.collides = false;
  for (SceneJoint& joint : scene.joints) joint.compliance = chain.compliance;
  return scene;
}

void run_chain(Sheet& sheet, const Chain& chain) {
  const Scene scene = chain_scene(chain);
  const auto engine = sheet.make(scene);
  // The unit is M g L: with the floor one length of the chain below the start.
  const double start = mechanical_energy(scene, *engine);
  EnergyWatch energy(scene, *engine, start - energy_at_height(scene, chain.links * kLink));
  double separation = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    const double now = joint_separation(scene, *engine);
    separation = std::isnan(now) ? HUGE_VAL : std::max(separation, now);
  });
  sheet.at_most("separation", 1e3 * separation, 1.0, "mm", "joints hold");
  sheet.at_most("energy drift", energy.drift(), 0.01, "of M g L", "conserved");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of M g L", "passive");
}

/// One ball, fixed to two points 2 m apart.
void contradiction(Sheet& sheet) {
  Scene scene;
  const int ball = scene.add(SphereShape{0.5}, 1.0, at(0.3, 0.0, 0.0));
  for (const double x : {-1.0, 1.0}) {
    scene.joints.push_back({.a = -1, .b = ball, .anchor_a_l = Vec3(x, 0.0, 0.0)});
  }
  const auto engine = sheet.make(scene);
  double farthest = 0.0;
  double speed = 0.0;
  run_scene(scene, *engine, [&](double t) {
    const pbd::BodyState s = engine->state(ball);
    const double distance = s.pose.position.norm();
    farthest = std::isnan(distance) ? HUGE_VAL : std::max(farthest, distance);
    if (t > scene.seconds - 1.0) speed = std::max(speed, s.twist.linear.norm());
  });
  sheet.at_most("distance from the middle", farthest, 1.0, "m", "stays between the nails");
  sheet.at_most("speed in the last second", speed, 1e-3, "m/s", "at rest");
}

void ratio(Sheet& sheet) {
  const Scene scene = peer_scene("ratio");
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, 0.5));
  run_scene(scene, *engine, [&](double) { energy.after_frame(*engine); });
  const int top = static_cast<int>(scene.bodies.size()) - 1;
  const Vec3 moved = engine->state(top).pose.position - scene.bodies.back().pose.position;
  sheet.at_most("top error", 1e3 * moved.norm(), 5.0, "mm", "stands");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

/// Largest drift (m) of all bodies, and the energy.
void piles_stand(Sheet& sheet, const Scene& scene, double bound_mm) {
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, 0.5));
  run_scene(scene, *engine, [&](double) { energy.after_frame(*engine); });
  double drift = 0.0;
  for (int i = 1; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Vec3 moved =
        engine->state(i).pose.position - scene.bodies[static_cast<std::size_t>(i)].pose.position;
    // A cube at the same place a metre lower has not stood.
    const double now = std::abs(moved.z()) > 0.5 ? HUGE_VAL : horizontal_drift(scene, *engine, i);
    drift = std::isnan(now) ? HUGE_VAL : std::max(drift, now);
  }
  sheet.at_most("drift", 1e3 * drift, bound_mm, "mm", "stands");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

void tower(Sheet& sheet, int height, double bound_mm) {
  Scene scene;
  scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, at(0.0, 0.0, -1.0));
  for (int k = 0; k < height; ++k) scene.add(cube(1.0), 100.0, at(0.0, 0.0, 0.5 + k));
  piles_stand(sheet, scene, bound_mm);
}

void pyramid(Sheet& sheet, int base) {
  Scene scene;
  scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, at(0.0, 0.0, -1.0));
  for (int k = 0; k < base; ++k) {
    const int count = base - k;
    for (int i = 0; i < count; ++i) {
      scene.add(cube(1.0), 100.0, at((i - 0.5 * (count - 1)) * 1.02, 0.0, 0.5 + k));
    }
  }
  piles_stand(sheet, scene, 1.0);
}

}  // namespace

std::vector<Case> stiff_cases() {
  const std::string family = "stiff";
  std::vector<Case> cases;
  const auto add_chain = [&](const std::string& name, const Chain& chain) {
    cases.push_back({family, "chain of " + std::to_string(chain.links) + ", " + name,
                     [=](Sheet& s) { run_chain(s, chain); }});
  };
  constexpr double kSwing = std::numbers::pi / 3.0;
  constexpr double kDrop = std::numbers::pi / 2.0;
  for (const int links : {20, 50}) {
    for (const char* const mass : {"1", "100", "1000", "1e5"}) {
      add_chain(std::string("end ") + mass + " links", {links, std::stod(mass), kSwing});
    }
  }
  add_chain("end 100 links, compliance 1e-12 m/N", {20, 100.0, kSwing, 1e-12});
  // From the horizontal it goes slack after the first swing, and whips.
  add_chain("end 100 links, dropped", {20, 100.0, kDrop});
  add_chain("end 1 link, dropped", {50, 1.0, kDrop});
  add_chain("end 1000 links, dropped", {50, 1000.0, kDrop});
  cases.push_back({family, "two nails 2 m apart", contradiction});
  cases.push_back({family, "masses 1 to 10000 kg, light below", ratio});
  for (const auto& [height, bound] :
       {std::pair(10, 1.0), std::pair(20, 5.0), std::pair(50, 20.0)}) {
    cases.push_back({family, "tower of " + std::to_string(height),
                     [height = height, bound = bound](Sheet& s) { tower(s, height, bound); }});
  }
  for (const int base : {15, 30}) {
    cases.push_back(
        {family, "pyramid of base " + std::to_string(base), [=](Sheet& s) { pyramid(s, base); }});
  }
  return cases;
}

}  // namespace tandem::bench
