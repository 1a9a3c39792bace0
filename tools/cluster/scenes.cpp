// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "demos/scenes/cliff_geometry.h"
#include "tandem/pbd/random.h"
#include "tandem/pbd/validate.h"

namespace tandem::cluster_tool {
namespace {

using collision::Shape;
using pbd::Vec3;

constexpr std::array<std::string_view, 5> kNames = {"cliff", "cubes", "edge", "heap", "pyramid"};
constexpr std::size_t kTile = 1000;  ///< bodies per tile of a large scene

/// A random number per body and stream, independent of the rank.
double uniform(std::size_t body, std::uint64_t stream) {
  return pbd::SplitMix64(0x51ed270b * (body + 1) + stream).uniform(0.0, 1.0);
}

SceneBody solid(std::size_t number, const Shape& shape, double mass, const Vec3& at) {
  const pbd::Mat3 inertia =
      collision::mass_properties(shape, 1.0).inertia / collision::mass_properties(shape, 1.0).mass;
  SceneBody body;
  body.def.mass = mass;
  body.def.inertia = mass * inertia;
  body.def.pose.position = at;
  body.def.stable_id = number;
  body.colliders.push_back({.body = {}, .shape = shape, .local = {}, .material = {}, .filter = {}});
  return body;
}

SceneBody fixed(const Shape& shape, const Vec3& at) {
  SceneBody body;
  body.def.type = pbd::BodyType::Static;
  body.def.pose.position = at;
  body.colliders.push_back({.body = {}, .shape = shape, .local = {}, .material = {}, .filter = {}});
  return body;
}

/// Walls along the sides of an empty rectangle.
void add_walls(Scene& scene, const Vec3& min, const Vec3& max) {
  constexpr double kThick = 1.0;
  const Vec3 middle = 0.5 * (min + max);
  const Vec3 half = 0.5 * (max - min);
  for (const double side : {-1.0, 1.0}) {
    scene.fixed.push_back(
        fixed(collision::Box{Vec3(kThick, half.y() + 2.0 * kThick, half.z())},
              Vec3(middle.x() + side * (half.x() + kThick), middle.y(), middle.z())));
    scene.fixed.push_back(
        fixed(collision::Box{Vec3(half.x(), kThick, half.z())},
              Vec3(middle.x(), middle.y() + side * (half.y() + kThick), middle.z())));
  }
}

/// m
Shape cliff_ground(double begin, double end) {
  const double cell = 2.0 * demos::kCliffHalf / demos::kCliffCells;
  const auto rows = static_cast<std::uint32_t>(std::ceil((end - begin) / cell));
  demos::CliffMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j) {
    for (std::uint32_t i = 0; i <= demos::kCliffCells; ++i) {
      const double x = -demos::kCliffHalf + cell * i;
      const double y = begin + cell * j;
      mesh.vertices.emplace_back(x, y, demos::cliff_height(x, y));
    }
  }
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < demos::kCliffCells; ++i) {
      const std::uint32_t a = j * (demos::kCliffCells + 1) + i;
      const std::uint32_t c = a + demos::kCliffCells + 1;
      mesh.triangles.push_back({a, a + 1, c + 1});
      mesh.triangles.push_back({a, c + 1, c});
    }
  }
  return collision::TriangleMesh::make(mesh.vertices, mesh.triangles);
}

/// The demo's cliff, with tiles of a thousand balls along its edge.
/// @param room  m, from the outer tiles to the walls
Scene cliff(std::size_t balls, double room) {
  constexpr double kWidth = 4.5;  // m, of a tile
  const std::size_t tiles = (balls + kTile - 1) / kTile;
  Scene scene;
  scene.bodies = balls;
  const double begin = -0.5 * kWidth - room;
  const double end = (static_cast<double>(tiles) - 0.5) * kWidth + room;
  scene.fixed.push_back(fixed(cliff_ground(begin, end), Vec3::Zero()));
  add_walls(scene, Vec3(-demos::kCliffHalf, begin, -2.0), Vec3(demos::kCliffHalf, end, 18.0));
  scene.body = [](std::size_t i) {
    const std::size_t place = i % kTile;
    const auto tile = static_cast<double>(i / kTile);
    const double x = (static_cast<double>(place % 10) - 4.5) * 0.45;
    const double y = (static_cast<double>(place / 10 % 10) - 4.5) * 0.45 + kWidth * tile;
    const double z = 7.0 + 0.45 * static_cast<double>(place / 100);
    const Vec3 off(0.04 * (uniform(i, 1) - 0.5), 0.04 * (uniform(i, 2) - 0.5), 0.0);
    return solid(i, collision::Sphere{demos::kCliffBallRadius}, 1.0, Vec3(x, y, z) + off);
  };
  return scene;
}

/// Stacks of five 0.1 m cubes on a square grid of 0.3 m; a heavy ball hits them.
Scene cubes(std::size_t stacks) {
  constexpr double kEdge = 0.1;
  constexpr double kSpacing = 0.3;
  constexpr std::size_t kHeight = 5;
  std::size_t side = 1;
  while (side * side < stacks) ++side;
  const double half = 0.5 * kSpacing * (static_cast<double>(side) - 1.0);
  Scene scene;
  scene.bodies = stacks * kHeight + 1;
  scene.fixed.push_back(fixed(collision::HalfSpace{}, Vec3::Zero()));
  scene.body = [=](std::size_t i) {
    if (i == stacks * kHeight) {
      SceneBody ball = solid(i, collision::Sphere{0.2}, 10.0, Vec3(-half - 1.0, 0.0, 0.2));
      ball.def.twist.linear = Vec3(6.0, 0.5, 0.0);
      return ball;
    }
    const std::size_t stack = i / kHeight;
    const double x = kSpacing * static_cast<double>(stack % side) - half;
    const double y = kSpacing * static_cast<double>(stack / side) - half;
    const double z = kEdge * (static_cast<double>(i % kHeight) + 0.5);
    return solid(i, collision::Box{Vec3::Constant(0.5 * kEdge)}, 0.3, Vec3(x, y, z));
  };
  return scene;
}

/// Balls and boxes that fall into a pit.
Scene heap(std::size_t bodies) {
  constexpr double kPitch = 0.25;  // m
  constexpr double kWidth = 10.0 * kPitch;
  const std::size_t tiles = (bodies + kTile - 1) / kTile;
  std::size_t side = 1;
  while (side * side < tiles) ++side;
  Scene scene;
  scene.bodies = bodies;
  scene.fixed.push_back(fixed(collision::HalfSpace{}, Vec3::Zero()));
  const auto columns = static_cast<double>(std::min(side, tiles));
  const auto rows = static_cast<double>((tiles + side - 1) / side);
  add_walls(scene, Vec3(0.0, 0.0, -1.0), Vec3(kWidth * columns, kWidth * rows, 6.0));
  scene.body = [=](std::size_t i) {
    const std::size_t place = i % kTile;
    const std::size_t tile = i / kTile;
    const Vec3 at(kPitch * (static_cast<double>(place % 10) + 0.5) +
                      kWidth * static_cast<double>(tile % side),
                  kPitch * (static_cast<double>(place / 10 % 10) + 0.5) +
                      kWidth * static_cast<double>(tile / side),
                  0.15 + kPitch * static_cast<double>(place / 100));
    const Vec3 off(0.04 * (uniform(i, 1) - 0.5), 0.04 * (uniform(i, 2) - 0.5), 0.0);
    const double size = 0.07 + 0.03 * uniform(i, 3);  // m
    if (i % 2 == 0) return solid(i, collision::Sphere{size}, 1.0, at + off);
    return solid(i, collision::Box{Vec3(size, size, 0.8 * size)}, 1.0, at + off);
  };
  return scene;
}

/// A pyramid of cubes, one cube thick: one island.
Scene pyramid(std::size_t row) {
  constexpr double kEdge = 0.1;
  Scene scene;
  scene.bodies = row * (row + 1) / 2;
  scene.fixed.push_back(fixed(collision::HalfSpace{}, Vec3::Zero()));
  scene.body = [=](std::size_t i) {
    std::size_t level = 0;
    std::size_t place = i;
    while (place >= row - level) place -= row - level++;
    const double x = kEdge * 1.05 *
                     (static_cast<double>(place) + 0.5 * static_cast<double>(level) -
                      0.5 * static_cast<double>(row - 1));
    const Vec3 at(x, 0.0, kEdge * (static_cast<double>(level) + 0.5));
    return solid(i, collision::Box{Vec3::Constant(0.5 * kEdge)}, 0.3, at);
  };
  return scene;
}

}  // namespace

std::span<const std::string_view> scene_names() { return kNames; }

Scene make_scene(std::string_view name, std::size_t size) {
  const auto or_else = [size](std::size_t fallback) { return size > 0 ? size : fallback; };
  Scene scene;
  if (name == "cliff") {
    scene = cliff(or_else(1000), demos::kCliffHalf - 2.25);
  } else if (name == "edge") {
    scene = cliff(or_else(1000), 0.0);
  } else if (name == "cubes") {
    scene = cubes(or_else(100));
  } else if (name == "heap") {
    scene = heap(or_else(1000));
  } else if (name == "pyramid") {
    scene = pyramid(or_else(20));
  } else {
    pbd::detail::refuse("scene", "cliff, cubes, edge, heap or pyramid", name);
  }
  scene.name = name;
  return scene;
}

}  // namespace tandem::cluster_tool
