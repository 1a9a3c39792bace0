// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <cstdio>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/solver.h"

// A box falls by a centimetre and rests on a half-space.
int main() {
  using namespace tandem;
  pbd::World world;
  const pbd::BodyId ground = world.add_body({.type = pbd::BodyType::Static});
  const pbd::BodyId box = world.add_body({.pose = {.position = pbd::Vec3(0, 0, 0.51)}});
  collision::CollisionScene scene;
  scene.add(world, {.body = ground, .shape = collision::HalfSpace{}});
  scene.add(world, {.body = box, .shape = collision::Box{}});
  world.set_contact_source(&scene);
  pbd::Solver solver;
  for (int i = 0; i < 120; ++i) {
    if (solver.step(world, 1.0 / 60.0).status != pbd::StepStatus::Ok) return 1;
  }
  const double height = world.pose(box).position.z();
  std::printf("collision: the box of 1 m rests at %.4f m\n", height);
  return std::abs(height - 0.5) < 1e-3 ? 0 : 1;
}
