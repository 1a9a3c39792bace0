// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <tandem/scene.h>

#include <cmath>

// A cube of 0.1 m falls from 1 m and lies on the ground.
int main() {
  tandem::Scene scene;
  scene.add(tandem::HalfSpace{}, {.type = tandem::BodyType::Static});
  const auto cube = scene.add(tandem::Box{0.05, 0.05, 0.05}, {.pose = {.position = {0, 0, 1}}});
  for (int i = 0; i < 120; ++i) scene.step(1.0 / 60.0);
  return std::abs(scene.pose(cube).position.z() - 0.05) < 1e-3 ? 0 : 1;
}
