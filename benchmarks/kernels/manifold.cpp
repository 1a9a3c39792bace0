// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// One manifold, by pair of shapes: 64 separate pairs, without recycling. pair_time is that of one
// pair, broad phase included.
#include <benchmark/benchmark.h>

#include <numbers>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/workers.h"
#include "tandem/pbd/world.h"

namespace {

using namespace tandem;
using collision::Shape;
using pbd::Pose;
using pbd::Vec3;

constexpr int kPairs = 64;

Pose at(double z, const Vec3& turn = Vec3::Zero()) {
  return {.position = Vec3(0.0, 0.0, z), .orientation = pbd::exp_map(turn)};
}

/// Flat square of side 4 in 16 x 16 cells.
collision::Mesh flat_mesh() {
  constexpr std::uint32_t kCells = 16;
  std::vector<Vec3> v;
  std::vector<collision::TriangleMesh::Triangle> t;
  for (std::uint32_t j = 0; j <= kCells; ++j) {
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      v.emplace_back(4.0 * i / kCells - 2.0, 4.0 * j / kCells - 2.0, 0.0);
    }
  }
  for (std::uint32_t j = 0; j < kCells; ++j) {
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i;
      t.push_back({a, a + 1, a + kCells + 2});
      t.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  }
  return collision::TriangleMesh::make(v, t);
}

/// The lower shape is at the origin, the upper one overlaps it by about 1 mm.
void collect(benchmark::State& state, const Shape& lower, const Shape& upper, const Pose& pose) {
  pbd::World world;
  collision::CollisionScene scene({.recycle_distance = 0.0});
  for (int i = 0; i < kPairs; ++i) {
    const Vec3 place(10.0 * (i % 8), 10.0 * (i / 8), 0.0);
    const auto below = world.add_body({.type = pbd::BodyType::Static, .pose = {.position = place}});
    scene.add(world, {.body = below, .shape = lower});
    Pose moved = pose;
    moved.position += place;
    scene.add(world, {.body = world.add_body({.pose = moved}), .shape = upper});
  }
  pbd::Workers workers;
  std::vector<pbd::Manifold> out;
  for (auto _ : state) {
    out.clear();
    scene.collect(world, 1.0 / 60.0, workers, out);
    benchmark::DoNotOptimize(out.data());
  }
  state.counters["pair_time"] = benchmark::Counter(
      kPairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["points"] = static_cast<double>(scene.stats().points) / kPairs;
}

const collision::Box kCube{Vec3::Constant(0.5)};
const collision::Sphere kBall{0.5};
const collision::Capsule kCapsule{0.25, 0.5};
const Vec3 kLying(0.0, std::numbers::pi / 2.0, 0.0);

}  // namespace

BENCHMARK_CAPTURE(collect, ball_ball, kBall, kBall, at(0.999));
BENCHMARK_CAPTURE(collect, box_ball, kCube, kBall, at(0.999));
BENCHMARK_CAPTURE(collect, box_capsule_lying, kCube, kCapsule, at(0.749, kLying));
BENCHMARK_CAPTURE(collect, capsule_capsule_crossed, kCapsule, kCapsule, at(0.999, kLying));
BENCHMARK_CAPTURE(collect, box_box_face, kCube, kCube, at(0.999, Vec3(0.0, 0.0, 0.3)));
BENCHMARK_CAPTURE(collect, box_box_edge, kCube, kCube,
                  at(1.206, Vec3(std::numbers::pi / 4.0, 0.0, 0.2)));
BENCHMARK_CAPTURE(collect, mesh_ball, flat_mesh(), kBall, at(0.499));
BENCHMARK_CAPTURE(collect, mesh_capsule_lying, flat_mesh(), kCapsule, at(0.249, kLying));
BENCHMARK_CAPTURE(collect, mesh_box_face, flat_mesh(), kCube, at(0.499));
