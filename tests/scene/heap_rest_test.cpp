// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is thrown on a heap or built into a tower comes to rest.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tandem/pbd/math.h"
#include "tandem/pbd/random.h"
#include "tandem/scene.h"

namespace tandem::heap_rest_test {
namespace {

using collision::ConvexHull;
using collision::TriangleMesh;

constexpr double kStep = 1.0 / 60.0;  // s

/// Boxes that fall in layers of nine, turned at random.
std::vector<BodyId> rain(Scene& scene, pbd::SplitMix64& random, int count) {
  std::vector<BodyId> bodies;
  const double size = random.uniform(0.1, 0.5);  // m
  const auto some = [&] { return random.uniform(-1.0, 1.0); };
  for (int i = 0; i < count; ++i) {
    const Vec3 place(0.45 * (i % 3 - 1), 0.45 * (i / 3 % 3 - 1), 0.4 + 0.45 * (i / 9));
    const Vec3 edges(0.6, random.uniform(0.4, 0.6), random.uniform(0.3, 0.6));
    bodies.push_back(
        scene.add(Box{Vec3(0.5 * size * edges)},
                  {.pose = {.position = size / 0.35 * place + 0.05 * size * Vec3(some(), some(), 0),
                            .orientation = pbd::exp_map(3.0 * Vec3(some(), some(), some()))},
                   .material = {.friction = 0.6}}));
  }
  return bodies;
}

/// Level, from -reach to reach (m), of pairs of triangles; no seam goes through its middle.
std::shared_ptr<const TriangleMesh> level_mesh(double reach) {
  constexpr std::uint32_t cells = 24;
  std::vector<Vec3> corners;
  std::vector<TriangleMesh::Triangle> triangles;
  const auto along = [&](std::uint32_t i) { return reach * (2.0 * i / cells - 1.0); };
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      corners.emplace_back(along(i) + 0.013 * reach, along(j) + 0.007 * reach, 0.0);
      if (i == cells || j == cells) continue;
      const std::uint32_t a = j * (cells + 1) + i;
      const std::uint32_t d = a + cells + 2;
      triangles.push_back({a, a + 1, d});
      triangles.push_back({a, d, d - 1});
    }
  }
  return TriangleMesh::make(corners, triangles);
}

/// A tin of 24 sides whose points are off by up to `error` (m).
std::vector<Vec3> scanned_tin(pbd::SplitMix64& random, double size, double error) {
  const auto in_ball = [&] {
    for (;;) {
      Vec3 p;
      for (double& each : p) each = random.uniform(-1.0, 1.0);
      if (p.norm() <= 1.0) return p;
    }
  };
  std::vector<Vec3> points;
  for (int i = 0; i < 24; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / 24.0;
    for (const double z : {-0.5, 0.5}) {
      points.emplace_back(size * Vec3(0.35 * std::cos(turn), 0.35 * std::sin(turn), z) +
                          error * in_ball());
    }
  }
  return points;
}

}  // namespace

TEST_CASE("scene: in a heap of boxes nothing creeps on", "[scene][property][long]") {
  pbd::SplitMix64 random(91);
  for (int run = 0; run < 8; ++run) {
    Scene scene({.solver = {.sleep_after = 0.0}});
    scene.add(HalfSpace{}, {.type = BodyType::Static, .material = {.friction = 0.6}});
    const std::vector<BodyId> bodies = rain(scene, random, run % 2 == 0 ? 60 : 150);
    for (int k = 0; k < 480; ++k) scene.step(kStep);
    std::vector<Vec3> before;
    for (const BodyId id : bodies) before.push_back(scene.pose(id).position);
    for (int k = 0; k < 60; ++k) scene.step(kStep);
    int creep = 0;  // by more than 1 mm/s
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if ((scene.pose(bodies[i]).position - before[i]).norm() > 1e-3) ++creep;
    }
    INFO("run " << run << " of " << bodies.size());
    CHECK(creep <= 1);  // one may still roll over
  }
}

// Of the corners that nearly touch four are chosen. The one that the body tips on to was not one of
// them, bore once it was found, and was left out again: 42 of 4000 like these rocked without end,
// one does.
TEST_CASE("scene: scanned tins do not rock", "[scene][property]") {
  for (int run = 0; run < 200; ++run) {
    pbd::SplitMix64 random(static_cast<std::uint64_t>(50 + run));
    Scene scene({.solver = {.sleep_after = 0.0}});
    const double size = std::exp(random.uniform(std::log(0.03), std::log(1.0)));  // m
    const double error = size * std::exp(random.uniform(std::log(1e-4), std::log(5e-3)));
    const auto hull = ConvexHull::make(scanned_tin(random, size, error));
    scene.add(level_mesh(10.0 * size), {.type = BodyType::Static, .material = {.friction = 0.5}});
    const BodyId tin = scene.add(hull, {.pose = {.position = Vec3(0.0, 0.0, 0.6 * size)}});
    double spin = 0.0;
    for (int k = 0; k < 360; ++k) {
      scene.step(kStep);
      if (k >= 300) spin = std::max(spin, scene.world().twist(tin).angular.norm());
    }
    INFO("run " << run << ": " << size << " m, points off by " << error << " m");
    CHECK(spin <= 1e-3);
  }
}

TEST_CASE("scene: towers that nobody has built exactly stand still and sleep",
          "[scene][property]") {
  pbd::SplitMix64 random(92);
  for (int run = 0; run < 24; ++run) {
    Scene scene;
    scene.add(HalfSpace{}, {.type = BodyType::Static, .material = {.friction = 0.6}});
    const double edge = std::exp(random.uniform(std::log(0.05), std::log(2.0)));  // m
    const int count = 3 + static_cast<int>(random.uniform(0.0, 7.9));
    const double offset = random.uniform(0.0, 0.05) * edge;
    const double step = run % 2 == 0 ? kStep : 0.5 * kStep;
    std::vector<BodyId> cubes;
    for (int i = 0; i < count; ++i) {
      Vec3 place(0.0, 0.0, (0.5 + i) * edge);
      for (double& each : place.head<2>()) each = offset * random.uniform(-1.0, 1.0);
      cubes.push_back(scene.add(Box{Vec3::Constant(0.5 * edge)},
                                {.pose = {.position = place}, .material = {.friction = 0.6}}));
    }
    const Vec3 top = scene.pose(cubes.back()).position;
    const BodyId middle = cubes[cubes.size() / 2];
    const double touch = random.uniform(0.0, 0.05) * std::sqrt(9.81 * edge);  // m/s
    for (double time = 0.0; time < 6.5; time += step) {
      if (time < 0.5 && time + step >= 0.5) {
        const double mass = scene.world().props(middle).mass;
        scene.world().apply_impulse(middle, Vec3(mass * touch, 0.0, 0.0));
      }
      scene.step(step);
    }
    INFO("run " << run << ": " << count << " cubes of " << edge << " m, off by " << offset);
    CHECK_FALSE(scene.world().awake(cubes.back()));
    CHECK((scene.pose(cubes.back()).position - top).norm() < 0.01 * edge);
  }
}

}  // namespace tandem::heap_rest_test
