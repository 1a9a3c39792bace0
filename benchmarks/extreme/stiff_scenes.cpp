// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene.h"
#include "tandem/pbd/math.h"

namespace tandem::extreme_bench {
namespace {

constexpr double kLink = 0.1;  // m

/// Ten links of 0.1 kg hang from one user's hand and carry 100 kg, which another user moves.
Scene heavy_chain() {
  constexpr int kLinks = 10;
  constexpr double kHeavy = 100.0;
  const auto down = [](double links) { return up(-kLink * links); };
  Scene scene{.name = "chain 1000:1, two users", .group = "stiff", .seconds = 8.5};
  scene.build = [=](int) {
    CopyBuilder b;
    pbd::BodyId above;
    for (int i = 0; i <= kLinks; ++i) {
      const bool last = i == kLinks;
      const double half = last ? 2.0 * kLink : 0.5 * kLink;
      const Vec3 centre = last ? Vec3(down(kLinks + 2.0)) : Vec3(down(i + 0.5));
      const pbd::BodyId link = b.box({.pose = {centre, Quat::Identity()},
                                      .half = Vec3(0.5 * half, 0.5 * half, half),
                                      .mass = last ? kHeavy : 0.1,
                                      .collides = false});
      if (i > 0) b.joint(pbd::ball_joint_at(b.world(), above, link, down(i)));
      above = link;
    }
    return b.done();
  };
  scene.weight_from = kKnown;
  // The first hand carries everything: it starts above by the spring's static stretch.
  const double stiffness = 5e4;
  const double stretch = (kHeavy + 0.1 * kLinks) * 9.81 / stiffness;
  scene.hands = {
      {.peer = 0,
       .body = 0,
       .attachment_l = up(0.5 * kLink),
       .stiffness = stiffness,
       .damping = 2000.0,
       .path = [=](double) { return up(stretch); }},
      {.peer = 1, .body = kLinks, .stiffness = 2000.0, .damping = 200.0, .path = [=](double t) {
         return Vec3(0.3 * std::sin(std::numbers::pi * t), 0.0, down(kLinks + 2.0).z());
       }}};
  return scene;
}

/// Two cubes joined by a rigid bar of a metre, whose ends two users pull half a metre outwards.
Scene bar_pulled_apart() {
  constexpr double kHalfLength = 0.5;
  constexpr double kMass = 10.0;
  Scene scene{.name = "users pull a bar apart", .group = "stiff"};
  scene.build = [=](int) {
    CopyBuilder b;
    b.world().set_gravity(Vec3::Zero());
    const auto end = [&](double x) {
      return b.box(
          {.pose = {{x, 0.0, 0.0}, Quat::Identity()}, .half = Vec3::Constant(0.1), .mass = kMass});
    };
    const pbd::BodyId left = end(-kHalfLength);
    const pbd::BodyId right = end(kHalfLength);
    b.joint(pbd::fixed_joint_at(b.world(), left, right, Vec3::Zero()));
    return b.done();
  };
  for (int user = 0; user < 2; ++user) {
    const double side = user == 0 ? -1.0 : 1.0;
    scene.hands.push_back({.peer = user,
                           .body = static_cast<std::size_t>(user),
                           .stiffness = 5000.0,
                           .damping = 100.0,
                           .path = [=](double t) {
                             const double out = std::clamp(t - kKnown, 0.0, 0.5);
                             return Vec3(side * (kHalfLength + out), 0.0, 0.0);
                           }});
  }
  return scene;
}

/// Orientations that differ by half a turn.
Scene half_turn(const Vec3& axis, bool on_floor, const char* name) {
  Scene scene{.name = name, .group = "disagreement", .by_angle = true};
  scene.build = [=](int peer) {
    CopyBuilder b;
    if (on_floor) {
      floor(b);
    } else {
      b.world().set_gravity(Vec3::Zero());
    }
    const Quat turned = pbd::exp_map(axis * (std::numbers::pi * peer));
    b.box({.pose = {up(on_floor ? kHalf : 0.0), turned}});
    return b.done();
  };
  return scene;
}

Scene other_mass() {
  Scene scene = tug_of_war();
  scene.name = "masses 1 and 10 kg";
  scene.group = "stiff";
  scene.build = [](int peer) {
    CopyBuilder b;
    floor(b);
    box_at(b, up(kHalf), peer == 1 ? 10.0 : 1.0);
    return b.done();
  };
  return scene;
}

}  // namespace

std::vector<Scene> stiff_scenes() {
  return {heavy_chain(),
          bar_pulled_apart(),
          other_mass(),
          half_turn(Vec3::UnitZ(), false, "180 degrees, free body"),
          half_turn(Vec3(1.0, 1.0, 1.0).normalized(), false, "180 degrees, slanting axis"),
          half_turn(Vec3::UnitX(), true, "180 degrees, box on a floor")};
}

}  // namespace tandem::extreme_bench
