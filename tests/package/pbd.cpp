// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <cstdio>

#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/solver.h"

// A pendulum on a rigid rod keeps its length.
int main() {
  using namespace tandem::pbd;
  World world;
  const BodyId ball =
      world.add_body({.type = BodyType::Dynamic, .pose = {.position = Vec3(1, 0, 0)}});
  auto& rods = world.add_block<DistanceJoints>();
  rods.add(world, {.b = ball, .rest_length = 1.0});
  Solver solver;
  for (int i = 0; i < 60; ++i) {
    if (solver.step(world, 1.0 / 60.0).status != StepStatus::Ok) return 1;
  }
  const double length = world.pose(ball).position.norm();
  std::printf("pbd: rod of 1 m is %.6f m long after 1 s\n", length);
  return std::abs(length - 1.0) < 1e-3 && world.pose(ball).position.z() < -0.1 ? 0 : 1;
}
