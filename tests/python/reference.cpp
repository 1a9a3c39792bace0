// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What the Python package is compared with: the scenes of scenes.py in C++.
//   python_reference hash STEPS              that of ten_bodies() after so many steps
//   python_reference tutorial                those of the tutorial's first program, every half
//   second python_reference crowd STEPS             that of Crowd likewise python_reference file
//   PATH STEPS         that of a file likewise, then the names of its bodies python_reference loop
//   KIND WORLDS        for each line on standard input, a number of steps: make
//                                            them in all worlds and print the CPU time, s
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tandem/car.h"
#include "tandem/character.h"
#include "tandem/cloth.h"
#include "tandem/pbd/cpu_timer.h"
#include "tandem/ragdoll.h"
#include "tandem/rope.h"
#include "tandem/scene_files.h"

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

void print_hash(const Scene& scene) {
  std::printf("%llu\n", static_cast<unsigned long long>(scene.world().hash()));
}

/// docs/tutorial.md: falling.cpp, with hashes instead of heights.
void tutorial() {
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  scene.add(Box{0.1, 0.1, 0.1}, {.density = 250.0, .pose = {.position = {0.0, 0.0, 1.0}}});
  for (int i = 0; i <= 120; ++i) {
    if (i % 30 == 0) print_hash(scene);
    scene.step(1.0 / 60.0);
  }
}

/// Somebody who walks, a car, a crate on a rope, a flag on a pole and somebody who falls.
void crowd(int steps) {
  constexpr double kDt = 1.0 / 60.0;
  Scene scene;
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  Character hero(scene, {.position = {0.0, -3.0, 1.0}, .max_push = 300.0});
  Car car(scene, {.pose = {.position = {0.0, 3.0, 0.8}}, .mass = 1000.0});
  const BodyId hook =
      scene.add(Sphere{0.05}, {.type = BodyType::Static, .pose = {.position = {5.0, 0.0, 3.0}}});
  const BodyId crate =
      scene.add(Box{0.2, 0.2, 0.2}, {.mass = 10.0, .pose = {.position = {5.5, 0.0, 1.8}}});
  Rope rope(scene, {.from = {5.0, 0.0, 3.0}, .to = {5.5, 0.0, 2.0}, .particles = 12});
  rope.attach(0, hook);
  rope.attach(11, crate);
  const BodyId pole = scene.add(Box{0.02, 0.02, 1.0},
                                {.type = BodyType::Static, .pose = {.position = {-3.0, 0.0, 1.0}}});
  Cloth flag(scene, {.pose = {.position = {-3.0, 0.0, 1.0}}, .columns = 8, .rows = 6});
  for (int row = 0; row < flag.rows(); ++row) flag.attach(0, row, pole);
  flag.tether();
  flag.add_handle(1.0, 0.5, 0.3, 0.5);
  Ragdoll victim(scene, {.pose = {.position = {0.0, -6.0, 0.5}}, .mass = 80.0});
  for (int i = 0; i < steps; ++i) {
    if (i == 20) hero.jump(3.0);
    hero.walk({1.5, 0.5, 0.0}, kDt);
    car.drive({.throttle = i < 60 ? 0.8 : 0.0, .steer = 0.2, .brake = i < 60 ? 0.0 : 0.5});
    scene.step(kDt);
  }
  print_hash(scene);
}

void file(const std::string& path, int steps) {
  SceneFile file = load_scene(path, {.solver = {.substeps = 3}});
  for (int i = 0; i < steps; ++i) file.scene.step(1.0 / 60.0);
  print_hash(file.scene);
  for (const SceneFile::Body& body : file.bodies) std::puts(body.name.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "hash") {
    Scene scene = ten_bodies(0, "boxes");
    for (int i = std::stoi(arguments[1]); i > 0; --i) scene.step(1.0 / 60.0);
    print_hash(scene);
    return 0;
  }
  if (arguments.size() == 1 && arguments[0] == "tutorial") {
    tutorial();
    return 0;
  }
  if (arguments.size() == 2 && arguments[0] == "crowd") {
    crowd(std::stoi(arguments[1]));
    return 0;
  }
  if (arguments.size() == 3 && arguments[0] == "file") {
    file(arguments[1], std::stoi(arguments[2]));
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
