// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Sizes, masses, seeds and the order of the random numbers are those used to measure other engines.
// Loops run z outermost, then y, then x.
#include <stdexcept>
#include <utility>

#include "demos/engine/scene.h"
#include "demos/scenes/cliff_geometry.h"
#include "scenes/place.h"
#include "scenes/random.h"
#include "tandem/pbd/validate.h"

namespace tandem::bench {
namespace {

BoxShape cube(double side) { return {Vec3::Constant(0.5 * side)}; }

void build_cliff(Scene& scene) {
  SceneRandom random;
  demos::CliffMesh surface = demos::cliff_mesh();
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices = std::move(surface.vertices);
  mesh->triangles = std::move(surface.triangles);
  scene.add_static(MeshShape(std::move(mesh)));
  for (const Vec3& where : demos::cliff_balls([&random] { return random.u(); })) {
    scene.add(SphereShape{demos::kCliffBallRadius}, 1.0, {.position = where});
  }
}

void build_stacks(Scene& scene) {
  add_ground(scene);
  for (int k = 0; k < 10; ++k) {
    for (int i = 0; i < 10; ++i) scene.add(cube(1.0), 100.0, place((i - 4.5) * 4.0, 0.0, 0.5 + k));
  }
}

void build_katamari(Scene& scene) {
  SceneRandom random;
  add_ground(scene);
  for (int k = 0; k < 9; ++k) {
    for (int j = 0; j < 10; ++j) {
      for (int i = 0; i < 10; ++i) {
        Pose pose = place((i - 4.5) * 0.7, (j - 4.5) * 0.7, 0.6 + 0.7 * k);
        pose.orientation = random.orientation(3.14159);
        scene.add(cube(0.4), 64.0, pose);
      }
    }
  }
  Pose pose = place(0.1, 0.05, 8.5);
  pose.orientation = random.orientation(1.0);
  scene.add(cube(1.5), 3375.0, pose);
}

void build_chain(Scene& scene) {
  constexpr int kLinks = 50;
  constexpr double kLength = 0.2;
  scene.seconds = 5.0;
  for (int i = 0; i < kLinks; ++i) {
    const int link =
        scene.add(BoxShape{Vec3(0.1, 0.025, 0.025)}, 1.0, place((i + 0.5) * kLength, 0.0, 0.0));
    scene.add_ball(link - 1, link, Vec3(i * kLength, 0.0, 0.0));
  }
  const int ball = scene.add(SphereShape{0.3}, 1000.0, place(kLinks * kLength + 0.3, 0.0, 0.0));
  scene.add_ball(ball - 1, ball, Vec3(kLinks * kLength, 0.0, 0.0));
  for (SceneBody& body : scene.bodies) body.collides = false;
}

void build_heap(Scene& scene) {
  SceneRandom random;
  add_ground(scene);
  for (const double side : {-1.0, 1.0}) {
    scene.add_static(BoxShape{Vec3(1.0, 7.0, 8.0)}, place(6.0 * side, 0.0, 8.0));
    scene.add_static(BoxShape{Vec3(7.0, 1.0, 8.0)}, place(0.0, 6.0 * side, 8.0));
  }
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 20; ++i) {
        Pose pose = place((i - 9.5) * 0.45, (j - 9.5) * 0.45, 0.4 + 0.45 * k);
        pose.orientation = random.orientation(0.4);
        scene.add(cube(0.3), 27.0, pose);
      }
    }
  }
}

void build_ratio(Scene& scene) {
  add_ground(scene);
  double mass = 1.0;
  for (int k = 0; k < 5; ++k, mass *= 10.0) scene.add(cube(1.0), mass, place(0.0, 0.0, 0.5 + k));
}

void build_pyramid(Scene& scene) {
  constexpr int kRows = 15;
  add_ground(scene);
  for (int k = 0; k < kRows; ++k) {
    const int count = kRows - k;
    for (int i = 0; i < count; ++i) {
      scene.add(cube(1.0), 100.0, place((i - 0.5 * (count - 1)) * 1.02, 0.0, 0.5 + k));
    }
  }
}

/// Rows of 1 m cubes, each shifted by half a cube from the one below.
void add_pyramid(Scene& scene, int base, double x, double y) {
  for (int row = 0; row < base; ++row) {
    const int count = base - row;
    for (int i = 0; i < count; ++i) {
      scene.add(cube(1.0), 1000.0, place(x + i - 0.5 * (count - 1), y, 0.5 + row));
    }
  }
}

void build_large_pyramid(Scene& scene) {
  scene.seconds = 200.0 / 60.0;
  add_ground(scene);
  add_pyramid(scene, 100, 0.0, 0.0);
}

void build_many_pyramids(Scene& scene) {
  constexpr int kSide = 14;
  scene.seconds = 1.0;
  add_ground(scene);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      add_pyramid(scene, 10, 12.0 * (i - 0.5 * kSide), 4.0 * (j - 0.5 * kSide));
    }
  }
}

}  // namespace

double cliff_height(double x, double y) { return demos::cliff_height(x, y); }

Scene peer_scene(std::string_view name) {
  using Build = void (*)(Scene&);
  constexpr std::array<Build, kPeerScenes.size()> kBuilds{
      build_cliff, build_stacks, build_katamari, build_chain,
      build_heap,  build_ratio,  build_pyramid};
  constexpr std::array<Build, kLargeScenes.size()> kLargeBuilds{build_large_pyramid,
                                                                build_many_pyramids};
  const auto built = [&](Build build) {
    Scene scene;
    scene.name = name;
    build(scene);
    return scene;
  };
  for (std::size_t i = 0; i < kPeerScenes.size(); ++i) {
    if (kPeerScenes[i] == name) return built(kBuilds[i]);
  }
  for (std::size_t i = 0; i < kLargeScenes.size(); ++i) {
    if (kLargeScenes[i] == name) return built(kLargeBuilds[i]);
  }
  pbd::detail::refuse("scene",
                      "cliff, stacks, katamari, chain, heap, ratio, pyramid, large_pyramid or "
                      "many_pyramids",
                      name);
}

}  // namespace tandem::bench
