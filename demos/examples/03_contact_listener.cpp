// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Shapes, and a listener of your own: what begins to touch, what ends, how hard it hits. A ball of
// restitution 0.5 falls on the ground; each hit is half as fast as the one before.
#include <cmath>
#include <cstdio>
#include <vector>

#include "tandem/collision/contact_events.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/solver.h"

using namespace tandem;

/// What a game would play sounds by.
class Listener {
 public:
  void on_begin(const collision::ContactPair& /*pair*/) { ++begun; }
  void on_end(const collision::ContactPair& /*pair*/) { ++ended; }
  void on_hit(const collision::ContactHit& hit, double time) {
    std::printf("%.3f s: hit at %.3f m/s, %.3f N s\n", time, hit.speed, hit.impulse);
    speeds.push_back(hit.speed);
  }

  int begun = 0;
  int ended = 0;
  std::vector<double> speeds;  // m/s
};

int main() {
  constexpr double kHeight = 2.0;       // m, from the ball's lowest point
  constexpr double kRadius = 0.1;       // m
  constexpr double kRestitution = 0.5;  // of the pair: the larger one of both

  pbd::World world;
  collision::CollisionScene scene;
  world.set_contact_source(&scene);
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  const collision::Sphere shape{kRadius};
  const collision::MassProperties solid = collision::mass_properties(shape, 500.0);
  const pbd::BodyId ball =
      world.add_body({.pose = {.position = pbd::Vec3(0.0, 0.0, kHeight + kRadius)},
                      .mass = solid.mass,
                      .inertia = solid.inertia_l});
  scene.add(world, {.body = ball, .shape = shape, .material = {.restitution = kRestitution}});

  Listener listener;
  collision::ContactEvents events({.hit_speed = 0.5});
  pbd::Solver solver;
  while (world.time() < 4.0) {
    if (solver.step(world, 1.0 / 240.0).status != pbd::StepStatus::Ok) return 1;
    events.update(world, scene);
    for (const collision::ContactPair& pair : events.begun()) listener.on_begin(pair);
    for (const collision::ContactPair& pair : events.ended()) listener.on_end(pair);
    for (const collision::ContactHit& hit : events.hits()) listener.on_hit(hit, world.time());
  }

  // sqrt(2 g h) at first, then half of the one before; in the end it lies there.
  const std::vector<double>& speeds = listener.speeds;
  bool holds = speeds.size() >= 3 && listener.begun == listener.ended + 1;
  double expected = std::sqrt(2.0 * 9.81 * kHeight);
  for (std::size_t i = 0; holds && i < 3; ++i) {
    holds = std::abs(speeds[i] / expected - 1.0) < 0.02;
    expected *= kRestitution;
  }
  std::printf("%d times begun, %d times ended, at rest at %.4f m\n", listener.begun, listener.ended,
              world.pose(ball).position.z());
  return holds && std::abs(world.pose(ball).position.z() - kRadius) < 1e-3 ? 0 : 1;
}
