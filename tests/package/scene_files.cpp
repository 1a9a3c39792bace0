// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/scene_files.h"

#include <cmath>
#include <cstdio>

// A ball on the ground, by text, and by the text that is written of it.
int main() {
  using namespace tandem;
  const SceneFile first = parse_scene(R"({"bodies": [
    {"type": "static", "shape": {"type": "halfSpace"}},
    {"name": "ball", "shape": {"type": "sphere", "radius": 0.1}, "position": [0, 0, 0.3]}]})");
  SceneFile file = parse_scene(write_scene(first));
  for (int i = 0; i < 120; ++i) file.scene.step(1.0 / 60.0);
  const double height = file.scene.pose(file.find("ball")).position.z();
  std::printf("scene_files: the ball lies at %.3f m\n", height);
  try {
    parse_scene("{");
    return 1;
  } catch (const SceneFileError&) {
  }
  return std::abs(height - 0.1) < 1e-3 ? 0 : 1;
}
