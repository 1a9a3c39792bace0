// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/scene.h"

#include <cmath>
#include <cstdio>

// A box falls by a centimetre and rests on a half-space.
int main() {
  using namespace tandem;
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  const BodyId box = scene.add(Box{}, {.pose = {.position = Vec3(0, 0, 0.51)}});
  for (int i = 0; i < 120; ++i) {
    if (scene.step(1.0 / 60.0).status != pbd::StepStatus::Ok) return 1;
  }
  const double height = scene.pose(box).position.z();
  std::printf("scene: the box of 1 m rests at %.4f m\n", height);
  return std::abs(height - 0.5) < 1e-3 ? 0 : 1;
}
