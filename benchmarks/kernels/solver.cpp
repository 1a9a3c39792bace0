// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Cost at the default setting of contacts in a resting tower (recycled, so that nearly all time is
// the solver's) and links of a swinging chain. row_time is that of one manifold or joint in one
// substep. body_time is that of one box in a whole step with detection, in up to 64 000 boxes in
// stacks of ten, kept awake.
#include "tandem/pbd/solver.h"

#include <benchmark/benchmark.h>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"

namespace {

using namespace tandem;
using pbd::Vec3;

constexpr double kDt = 1.0 / 60.0;

/// s per row.
benchmark::Counter row_time(double rows) {
  return {rows, benchmark::Counter::kIsRate | benchmark::Counter::kInvert};
}

/// Stacks of cubes that are kept awake.
struct Stacks {
  Stacks(int count, int height) {
    world.set_contact_source(&shapes);
    shapes.add(world, {.body = world.add_body({.type = pbd::BodyType::Static}),
                       .shape = collision::HalfSpace{}});
    const collision::Box cube{Vec3::Constant(0.5)};
    const auto mass = collision::mass_properties(cube, 100.0);
    for (int stack = 0; stack < count; ++stack) {
      const Vec3 foot(3.0 * (stack % 100), 3.0 * (stack / 100), 0.5);
      for (int k = 0; k < height; ++k) {
        const auto body = world.add_body({.pose = {.position = foot + Vec3(0.0, 0.0, k)},
                                          .mass = mass.mass,
                                          .inertia = mass.inertia});
        shapes.add(world, {.body = body, .shape = cube});
      }
    }
  }
  int step() { return solver.step(world, kDt).substeps; }

  pbd::World world;
  collision::CollisionScene shapes;
  pbd::Solver solver{{.sleep_after = 0.0}};
};

void contact_rows(benchmark::State& state) {
  Stacks stacks(10, static_cast<int>(state.range(0)));
  for (int i = 0; i < 60; ++i) stacks.step();
  int substeps = 0;
  for (auto _ : state) substeps += stacks.step();
  state.counters["row_time"] = row_time(10.0 * substeps * static_cast<double>(state.range(0)));
}

void boxes(benchmark::State& state) {
  constexpr int kHeight = 10;
  Stacks stacks(static_cast<int>(state.range(0)) / kHeight, kHeight);
  for (int i = 0; i < 10; ++i) stacks.step();
  double stepped = 0.0;
  for (auto _ : state) {
    stacks.step();
    stepped += static_cast<double>(state.range(0));
  }
  state.counters["body_time"] = row_time(stepped);
}

void ball_joint_rows(benchmark::State& state) {
  pbd::World world;
  auto& balls = world.add_block<pbd::JointBlock>();
  pbd::BodyId last;
  for (int i = 0; i < state.range(0); ++i) {
    const auto body = world.add_body({.pose = {.position = Vec3(0.2 * i + 0.1, 0.0, 0.0)},
                                      .inertia = pbd::Mat3::Identity() * 4e-3});
    balls.add(world, pbd::ball_joint_at(world, last, body, Vec3(0.2 * i, 0.0, 0.0)));
    last = body;
  }
  pbd::Solver solver;
  int substeps = 0;
  for (auto _ : state) substeps += solver.step(world, kDt).substeps;
  state.counters["row_time"] = row_time(1.0 * substeps * static_cast<double>(state.range(0)));
}

}  // namespace

BENCHMARK(contact_rows)->Arg(1)->Arg(10);
BENCHMARK(ball_joint_rows)->Arg(1)->Arg(10)->Arg(50);
BENCHMARK(boxes)->Arg(1000)->Arg(4000)->Arg(16000)->Arg(64000)->Unit(benchmark::kMillisecond);
