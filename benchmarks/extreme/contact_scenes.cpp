// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene.h"

namespace tandem::extreme_bench {
namespace {

constexpr double kWallFace = 1.0;  // m

/// A user's path 1.5 m into the wall, and back unless it stays.
Vec3 there_and_back(double time, const Vec3& start, bool stays) {
  const double out = std::clamp(time - 0.5, 0.0, 1.5);
  const double back = stays ? 0.0 : std::clamp(time - 3.5, 0.0, 1.5);
  return start + Vec3(out - back, 0.0, 0.0);
}

Copy boxes_before_wall(int boxes, double nearer) {
  CopyBuilder b;
  floor(b);
  b.wall({kWallFace - nearer + 0.5, 0.0, 1.0}, {0.5, 3.0, 1.0});
  for (int i = 0; i < boxes; ++i) box_at(b, {-0.5 * (boxes - 1 - i), 0.0, kHalf});
  return b.done();
}

/// S1, S2 and S4: a user at peer 1 pushes boxes against a wall.
Scene into_wall(std::string name, std::string group, int boxes, double nearer) {
  Scene scene{.name = std::move(name), .group = std::move(group), .seconds = 8.0};
  scene.build = [=](int peer) { return boxes_before_wall(boxes, peer == 1 ? nearer : 0.0); };
  const Vec3 start(-0.5 * (boxes - 1), 0.0, kHalf);
  scene.hands = {
      {.peer = 0, .path = [=](double t) { return there_and_back(t, start, nearer > 0.0); }}};
  scene.differs = nearer;
  return scene;
}

Copy stack(int boxes, double height = 0.0, double apart = 0.0) {
  CopyBuilder b;
  floor(b, height);
  for (int i = 0; i < boxes; ++i) box_at(b, {apart, 0.0, height + kHalf * (2 * i + 1)});
  return b.done();
}

Scene noisy_stack(std::string name, int boxes, double noise, double degrees) {
  Scene scene{.name = std::move(name), .group = "solver"};
  scene.build = [=](int) { return stack(boxes); };
  scene.conditions.noise = noise;
  scene.conditions.noise_angle = degrees * std::numbers::pi / 180.0;
  scene.stands = true;
  return scene;
}

Scene push_stack() {
  Scene scene{.name = "S7 box pushes stack", .group = "solver", .seconds = 7.0};
  scene.build = [](int) {
    CopyBuilder b;
    floor(b);
    box_at(b, {-1.0, 0.0, kHalf});
    for (int i = 0; i < 4; ++i) box_at(b, {0.0, 0.0, kHalf * (2 * i + 1)});
    return b.done();
  };
  scene.hands = {{.peer = 0, .path = [](double t) {
                    return Vec3(-1.0 + 0.4 * std::clamp(t - 0.5, 0.0, 4.0), 0.0, kHalf);
                  }}};
  return scene;
}

Scene other_floor(double lower, const char* text) {
  Scene scene{.name = std::string("floor ") + text, .group = "geometry"};
  scene.build = [=](int peer) { return stack(3, peer == 1 ? -lower : 0.0); };
  scene.differs = lower;
  return scene;
}

/// A box that is larger at one peer, pushed about under another one.
Scene other_size(double larger, const char* text) {
  Scene scene{.name = std::string("size ") + text, .group = "geometry"};
  scene.build = [=](int peer) {
    CopyBuilder b;
    floor(b);
    const double half = kHalf + (peer == 1 ? 0.5 * larger : 0.0);
    b.box({.pose = {up(half), Quat::Identity()}, .half = Vec3::Constant(half)});
    box_at(b, up(2.0 * half + kHalf));
    return b.done();
  };
  scene.differs = larger;
  return scene;
}

Copy free_box(double apart) {
  CopyBuilder b;
  b.world().set_gravity(Vec3::Zero());
  box_at(b, {apart, 0.0, 0.0});
  return b.done();
}

/// 10 cm between the copies.
std::vector<Scene> disagreements() {
  constexpr double kApart = 0.1;
  Scene free{.name = "10 cm, free body", .group = "disagreement"};
  free.build = [](int peer) { return free_box(peer * kApart); };
  Scene floor{.name = "10 cm, box on a floor", .group = "disagreement"};
  floor.build = [](int peer) { return stack(1, 0.0, peer * kApart); };
  Scene tower{.name = "10 cm, stack of five", .group = "disagreement"};
  tower.build = [](int peer) { return stack(5, 0.0, peer * kApart); };
  tower.stands = true;
  Scene moving{.name = "10 cm, boxes that part", .group = "disagreement"};
  moving.build = [](int peer) {
    CopyBuilder b;
    b.world().set_gravity(Vec3::Zero());
    b.box({.pose = {{peer * kApart, 0.0, 0.0}, Quat::Identity()},
           .twist = {{0.0, peer == 0 ? 0.5 : -0.5, 0.0}, {0.0, 0.0, peer == 0 ? 1.0 : -1.0}}});
    return b.done();
  };
  return {std::move(free), std::move(floor), std::move(tower), std::move(moving)};
}

}  // namespace

Vec3 up(double z) { return {0.0, 0.0, z}; }

void floor(CopyBuilder& b, double height) { b.wall(up(height - 0.5), {10.0, 10.0, 0.5}); }

pbd::BodyId box_at(CopyBuilder& b, const Vec3& position, double mass) {
  return b.box({.pose = {position, Quat::Identity()}, .mass = mass});
}

Scene tug_of_war() {
  Scene scene{.name = "S3 tug of war", .group = "solver", .seconds = 8.5};  // four periods
  scene.build = [](int) { return stack(1); };
  const auto begin = [](double t) { return std::clamp(t - kKnown, 0.0, 1.0); };
  scene.hands = {{.peer = 0,
                  .stiffness = 200.0,
                  .damping = 10.0,
                  .path = [=](double t) { return Vec3(-0.5 * begin(t), 0.0, kHalf); }},
                 {.peer = 1, .stiffness = 300.0, .damping = 10.0, .path = [=](double t) {
                    const double swing = 0.3 * std::sin(std::numbers::pi * (t - kKnown));
                    return Vec3(begin(t) * (0.5 + swing), 0.0, kHalf);
                  }}};
  return scene;
}

std::vector<Scene> contact_scenes() {
  std::vector<Scene> scenes;
  scenes.push_back(into_wall("S1 box into wall", "solver", 1, 0.0));
  scenes.push_back(into_wall("S2 row of three into wall", "solver", 3, 0.0));
  scenes.push_back(tug_of_war());
  scenes.push_back(into_wall("S4 wall 10 cm nearer", "geometry", 1, 0.1));
  scenes.push_back(noisy_stack("S5 noisy stack of five", 5, 2e-3, 0.0));
  scenes.push_back(push_stack());
  scenes.push_back(noisy_stack("noisy stack of ten", 10, 2e-3, 1.0));
  scenes.push_back(into_wall("wall 1 mm nearer", "geometry", 1, 1e-3));
  scenes.push_back(into_wall("wall 1 cm nearer", "geometry", 1, 1e-2));
  scenes.push_back(other_floor(1e-3, "1 mm lower"));
  scenes.push_back(other_floor(1e-2, "1 cm lower"));
  scenes.push_back(other_floor(1e-1, "10 cm lower"));
  scenes.push_back(other_size(1e-3, "1 mm larger"));
  scenes.push_back(other_size(1e-2, "1 cm larger"));
  scenes.push_back(other_size(1e-1, "10 cm larger"));
  for (Scene& scene : disagreements()) scenes.push_back(std::move(scene));
  return scenes;
}

}  // namespace tandem::extreme_bench
