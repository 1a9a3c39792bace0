// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/scene.h"

#include <cmath>
#include <cstdio>

// A cube of 0.1 m falls from 1 m: freely until it has fallen 0.78 m, and in the end it lies on the
// ground. As fall.py and fall.mjs do.
int main() {
  using namespace tandem;
  constexpr double dt = 1.0 / 240.0;  // s
  constexpr double gravity = 9.81;    // m/s^2
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId cube = scene.add(Box{0.05, 0.05, 0.05}, {.pose = {.position = Vec3(0, 0, 1)}});
  double error = 0.0;  // m
  for (int step = 1; step <= 480; ++step) {
    if (scene.step(dt).status != pbd::StepStatus::Ok) return 1;
    const double time = step * dt;
    if (time > 0.4) continue;
    // One velocity for each step, of its beginning or its end, is gt dt / 2 wrong; substeps do
    // better.
    const double height = 1.0 - gravity * time * time / 2.0;
    error = std::fmax(
        error, std::abs(scene.pose(cube).position.z() - height) / (gravity * time * dt / 2.0));
  }
  const double height = scene.pose(cube).position.z();
  std::printf("the cube lies at %.3f m; it fell with %.2f of the error allowed\n", height, error);
  return error < 1.0 && std::abs(height - 0.05) < 1e-3 ? 0 : 1;
}
