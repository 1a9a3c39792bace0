// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What the Python package is compared with: the scene of scenes.py in C++.
//   python_reference hash STEPS              its hash after so many steps
//   python_reference loop KIND WORLDS        for each line on standard input, a number of steps:
//   make
//                                            them in all worlds and print the CPU time, s
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tandem/pbd/cpu_timer.h"
#include "tandem/scene.h"

namespace {

using namespace tandem;

Scene ten_bodies(int number, const std::string& kind) {
  Scene scene({.solver = {.sleep_after = 0.0}});
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  for (int i = 0; i < 10; ++i) {
    if (kind == "boxes") {
      scene.add(
          Box{0.1, 0.1, 0.1},
          {.density = 500.0, .pose = {.position = {0.01 * i, 0.001 * number, 0.2 + 0.25 * i}}});
    } else {
      scene.add(Sphere{0.1},
                {.density = 500.0, .pose = {.position = {1.0 * i, 0.0, 100.0 + number}}});
    }
  }
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "hash") {
    Scene scene = ten_bodies(0, "boxes");
    for (int i = std::stoi(arguments[1]); i > 0; --i) scene.step(1.0 / 60.0);
    std::printf("%llu\n", static_cast<unsigned long long>(scene.world().hash()));
    return 0;
  }
  if (arguments.size() != 3 || arguments[0] != "loop") return 2;
  std::vector<Scene> scenes;
  for (int i = 0; i < std::stoi(arguments[2]); ++i) scenes.push_back(ten_bodies(i, arguments[1]));
  int steps = 0;
  while (std::scanf("%d", &steps) == 1) {
    const double begin = pbd::thread_cpu_seconds();
    for (Scene& scene : scenes) {
      for (int k = 0; k < steps; ++k) scene.step(1.0 / 60.0);
    }
    std::printf("%.9f\n", pbd::thread_cpu_seconds() - begin);
    std::fflush(stdout);
  }
  return 0;
}
