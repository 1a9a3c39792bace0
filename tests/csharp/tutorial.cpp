// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cstdint>

#include "reference.h"
#include "tandem/scene.h"

using namespace tandem;

// docs/tutorial.md: falling.cpp, with hashes instead of heights.
extern "C" void tutorial_of_cpp(std::uint64_t hashes[TUTORIAL_HASHES]) {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  scene.add(Box{0.1, 0.1, 0.1}, {.density = 250.0, .pose = {.position = {0.0, 0.0, 1.0}}});
  for (int i = 0; i <= 120; ++i) {
    if (i % 30 == 0) hashes[i / 30] = scene.world().hash();
    scene.step(1.0 / 60.0);
  }
}
