// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E12: a heavy load on a light rope swings down from horizontal.
#include <algorithm>
#include <cmath>
#include <vector>

#include "everyday/ground.h"
#include "everyday/group.h"
#include "tandem/rope.h"

namespace tandem::everyday {
namespace {

/// A rope of 1 kg that starts at `angle` from horizontal.
void swing(Tally& tally, double load, int particles, double length, double angle) {
  Scene scene;
  const BodyId hook = scene.add(Sphere{0.01}, {.type = BodyType::Static});
  const Vec3 end = length * Vec3(std::cos(angle), 0.0, -std::sin(angle));
  SolidDef def{.mass = load, .pose = {.position = end}, .filter = {.mask = 0}};
  const BodyId body = scene.add(Sphere{0.1}, def);
  Rope rope(scene,
            {.to = end, .particles = particles, .mass = 1.0, .radius = 0.005, .damping = 0.0});
  rope.attach(0, hook);
  rope.attach(rope.particles().size() - 1, body);
  const pbd::World& world = scene.world();
  const double start = world.mechanical_energy();
  const double range = kGravity * length * (load + 0.5);
  double stretch = 0.0;
  double gain = 0.0;
  for (int i = 0; i < 300; ++i) {
    scene.step(kFrame);
    double way = 0.0;
    Vec3 last = Vec3::Zero();
    for (const BodyId particle : rope.particles()) {
      way += (world.pose(particle).position - last).norm();
      last = world.pose(particle).position;
    }
    way += (world.pose(body).position - last).norm();
    stretch = std::isfinite(way) ? std::max(stretch, way / length - 1.0) : HUGE_VAL;
    gain = std::max(gain, (world.mechanical_energy() - start) / range);
  }
  const std::string which = told({{"particles", particles}, {"length", length}, {"angle", angle}});
  tally.at_most("stretch", 100.0 * stretch, load > 500.0 ? 5.0 : 2.0, "%", which);
  tally.at_most("energy gained, of its range", 1e3 * gain, 1.0, "1e-3", which);
}

}  // namespace

std::vector<Group> rope_groups() {
  std::vector<Group> groups;
  for (const int load : {10, 100, 1000}) {
    groups.push_back(
        {"E12", std::to_string(load) + " kg swing on a rope of 1 kg", "none",
         [=](Tally& tally, Extent extent) {
           const bool full = extent == Extent::Full;
           for (const int particles : full ? std::vector{7, 11, 21, 31, 61} : std::vector{11, 31}) {
             for (const double length : full ? std::vector{1.0, 3.0, 10.0} : std::vector{3.0}) {
               for (const double angle :
                    full ? std::vector{0.0, 0.5, 1.0, 1.47} : std::vector{0.0}) {
                 swing(tally, load, particles, length, angle);
               }
             }
           }
         },
         true});
  }
  return groups;
}

}  // namespace tandem::everyday
