// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A scene from a file: a door on a hinge, and a ball that rolls against it. Loading reports parts
// that Tandem does not support; a saved scene moves bit for bit like the original.
#include <cmath>
#include <cstdio>
#include <string>

#include "tandem/scene_files.h"

using namespace tandem;

// Contents of a file; load_scene(path) reads one.
const char* const kText = R"({
  "gravity": [0, 0, -9.81],
  "bodies": [
    {"name": "ground", "type": "static", "shape": {"type": "halfSpace"}},
    {"name": "door", "shape": {"type": "box", "halfExtents": [0.4, 0.02, 1]}, "density": 400,
     "position": [0.4, 0, 1.05]},
    {"name": "ball", "shape": {"type": "sphere", "radius": 0.2}, "density": 300,
     "position": [0.6, -1.5, 0.2], "linearVelocity": [0, 3, 0], "colour": "red", "smell": "none"}
  ],
  "joints": [
    {"name": "hinge", "type": "hinge", "b": "door", "at": {"position": [0, 0, 1], "axis": [0, 0, 1]},
     "axis": {"lower": 0, "upper": 1.4, "damping": 5}}
  ]
})";

int main() {
  SceneFile file = parse_scene(kText);
  for (const std::string& warning : file.warnings) std::printf("warning: %s\n", warning.c_str());

  SceneFile again = parse_scene(write_scene(file));
  for (int i = 0; i < 300; ++i) {
    file.scene.step(1.0 / 120.0);
    again.scene.step(1.0 / 120.0);
  }
  const double angle = file.scene.joints().hinge_angle(file.find_joint("hinge"));
  std::printf("the door is open by %.2f rad\n", angle);

  try {
    parse_scene(R"({"bodies": [{"shape": {"type": "sphere", "radius": -1}}]})", {}, "bad.json");
    return 1;
  } catch (const SceneFileError& error) {
    std::printf("%s\n", error.what());
  }
  const bool same = file.scene.world().hash() == again.scene.world().hash();
  return same && file.warnings.size() == 1 && angle > 0.2 && angle < 1.41 ? 0 : 1;
}
