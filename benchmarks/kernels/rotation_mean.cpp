// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Fusion of several peers' states of one body: the arguments are the number of states and their
// spread in degrees. Below 20 degrees power iterations, above it eigenvectors.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tandem/consensus/aggregate.h"
#include "tandem/pbd/math.h"

namespace {

using namespace tandem;
using pbd::Vec3;

void fuse(benchmark::State& state) {
  const auto peers = static_cast<std::size_t>(state.range(0));
  const double spread = static_cast<double>(state.range(1)) * std::numbers::pi / 180.0;
  std::vector<consensus::PeerEstimate> estimates(peers);
  for (std::size_t i = 0; i < peers; ++i) {
    const double t = static_cast<double>(i + 1);
    const Vec3 axis = Vec3(std::sin(t), std::cos(2.0 * t), std::sin(3.0 * t)).normalized();
    estimates[i].peer = static_cast<consensus::PeerId>(i + 1);
    estimates[i].pose = {.position = 0.01 * axis, .orientation = pbd::exp_map(0.5 * spread * axis)};
    estimates[i].share = 0.3;
  }
  pbd::PoseTarget target;
  for (auto _ : state) {
    benchmark::DoNotOptimize(consensus::fuse({}, estimates, target));
    benchmark::DoNotOptimize(target);
  }
}

}  // namespace

BENCHMARK(fuse)->ArgsProduct({{1, 2, 4, 8}, {1, 15, 40}})->ArgNames({"peers", "degrees"});
