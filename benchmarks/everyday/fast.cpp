// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E8: a bat hits its ball, and nothing goes through a wall.
#include <cmath>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"

namespace tandem::everyday {
namespace {

/// A bat of 1.2 m on a vertical hinge; the ball is `phase` of a step's turn off a whole number.
bool bat_hits(const bench::MakeEngine& peer, double spin, double phase, double ball_radius) {
  const auto world = make_world(peer, {.gravity = Vec3::Zero()});
  AnyWorld& scene = *world;
  const Vec3 half(0.6, 0.03, 0.03);
  const BodyId bat =
      scene.add(Box{half},
                {.pose = {.position = Vec3(0.6, 0.0, 0.0)},
                 .twist = {.linear = Vec3(0.0, 0.6 * spin, 0.0), .angular = Vec3(0.0, 0.0, spin)}});
  scene.add_hinge(bat, Vec3::Zero(), Vec3::UnitZ());
  const double step = spin * kFrame;
  const double angle = 0.3 + step * (1.0 + phase);
  const BodyId ball = scene.add(
      Sphere{ball_radius},
      {.density = 300.0, .pose = {.position = 0.95 * Vec3(std::cos(angle), std::sin(angle), 0.0)}});
  const int steps = static_cast<int>(std::ceil((angle + 0.3) / step)) + 1;
  for (int i = 0; i < steps; ++i) scene.step(kFrame);
  return scene.twist(ball).linear.norm() > 1.0;
}

void bat(Tally& tally, Extent extent, const bench::MakeEngine& peer, double spin, int allowed) {
  const int phases = extent == Extent::Full ? 24 : 6;
  for (int i = 0; i < phases; ++i) {
    const double phase = static_cast<double>(i) / phases;
    tally.failed("missed", !bat_hits(peer, spin, phase, 0.03), allowed, told({{"phase", phase}}));
  }
}

/// True if it ends beyond a wall of 1 cm. @param tilt  rad, scale of the random orientation
bool goes_through(const bench::MakeEngine& peer, const collision::Shape& shape, double speed,
                  double spin, double tilt, pbd::SplitMix64& random) {
  const auto world = make_world(peer);
  AnyWorld& scene = *world;
  scene.add(Box{0.005, 20.0, 20.0}, {.type = BodyType::Static});
  SolidDef def;
  def.pose.position = Vec3(-2.0 - speed * kFrame * random.unit(), 0.0, 0.0);
  def.pose.orientation = pbd::exp_map(
      tilt * Vec3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
  def.twist.linear = Vec3(speed, 0.0, 0.0);
  def.twist.angular =
      spin * Vec3(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
  const BodyId body = scene.add(shape, def);
  for (int i = 0; i < 30; ++i) scene.step(kFrame);
  // NaN counts as through.
  return !(scene.pose(body).position.x() < 0.0);
}

void wall(Tally& tally, Extent extent, const bench::MakeEngine& peer, const collision::Shape& shape,
          double speed, int allowed) {
  for (const double spin : {0.0, 20.0}) {
    pbd::SplitMix64 random(8);
    for (int i = 0; i < (extent == Extent::Full ? 60 : 10); ++i) {
      // 60 cases per spin; every second one hits nearly face on.
      const double tilt = i % 2 == 0 ? 3.0 : 0.1;
      tally.failed(told({{"through, spin", spin}}),
                   goes_through(peer, shape, speed, spin, tilt, random), allowed,
                   told({{"case", i}, {"tilt", tilt}}));
    }
  }
}

}  // namespace

std::vector<Group> fast_groups(const bench::MakeEngine& peer) {
  std::vector<Group> groups;
  for (const auto& [spin, allowed] : {std::pair{30, 0}, {60, 0}, {120, 1}}) {
    groups.push_back({"E8", "bat at " + std::to_string(spin) + " rad/s", "none",
                      [=](Tally& tally, Extent extent) { bat(tally, extent, peer, spin, allowed); },
                      true});
  }
  const std::vector<std::pair<std::string, collision::Shape>> shapes = {
      {"plate of 40 cm x 6 mm", Box{0.2, 0.2, 0.003}},
      {"cone of 10 cm", Cone{0.05, 0.05}},
      {"cube of 10 cm", Box{0.05, 0.05, 0.05}},
      {"sword of 1.2 m", Box{0.6, 0.02, 0.003}}};
  for (const auto& [name, shape] : shapes) {
    for (const auto& [speed, allowed] : {std::pair{100, 1}, {500, 2}}) {
      groups.push_back(
          {"E8", name + " at " + std::to_string(speed) + " m/s", "wall of 1 cm",
           [=](Tally& tally, Extent extent) { wall(tally, extent, peer, shape, speed, allowed); },
           true});
    }
  }
  return groups;
}

}  // namespace tandem::everyday
