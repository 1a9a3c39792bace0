// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A world, a body, a solver. A ball falls for a second; the result is compared with the formula.
#include <cmath>
#include <cstdio>

#include "tandem/pbd/solver.h"

int main() {
  using namespace tandem::pbd;

  World world;  // gravity (0, 0, -9.81) m/s^2
  const BodyId ball = world.add_body({.pose = {.position = Vec3(0.0, 0.0, 100.0)}, .mass = 2.0});
  Solver solver;

  constexpr double kStep = 1.0 / 60.0;  // s
  for (int i = 0; i < 60; ++i) {
    const StepReport& report = solver.step(world, kStep);
    if (report.status != StepStatus::Ok) return 1;
  }

  const double t = world.time();
  const double fallen = 100.0 - world.pose(ball).position.z();
  const double speed = -world.twist(ball).linear.z();
  std::printf("after %.3f s: fallen %.4f m (formula %.4f), speed %.4f m/s (formula %.4f)\n", t,
              fallen, 0.5 * 9.81 * t * t, speed, 9.81 * t);

  // The speed is exact. The distance is ahead by at most g t h / 2; the substep h is a quarter of a
  // step.
  const double ahead = fallen - 0.5 * 9.81 * t * t;
  const double most = 0.5 * 9.81 * t * 0.25 * kStep;
  return std::abs(speed - 9.81 * t) < 1e-9 && std::abs(ahead) < 1.001 * most ? 0 : 1;
}
