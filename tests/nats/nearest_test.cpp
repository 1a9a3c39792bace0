// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "nearest.h"

#include <algorithm>
#include <set>
#include <vector>

#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace tandem::nats::nearest_test {
namespace {

using consensus::PeerId;
using pbd::Vec3;

std::set<PeerId> set_of(std::span<const PeerId> peers) { return {peers.begin(), peers.end()}; }

TEST_CASE("nearest: the nearest within a slack, and jitter at the border is ignored", "[nats]") {
  constexpr std::size_t kChosen = 8;
  constexpr double kSlack = 1.0;
  pbd::SplitMix64 dice(3);
  Nearest nearest(kChosen, kSlack);
  std::vector<NearPeer> crowd;
  for (PeerId id = 1; id <= 20; ++id) {
    crowd.push_back({id, Vec3(dice.uniform(-8.0, 8.0), dice.uniform(-8.0, 8.0), 0.0)});
  }
  for (int step = 0; step < 500; ++step) {
    for (NearPeer& each : crowd) {
      each.position += Vec3(dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1), 0.0);
    }
    const auto chosen = set_of(nearest.choose(crowd, Vec3::Zero()));
    REQUIRE(chosen.size() == kChosen);
    double farthest = 0.0;
    double next = 1e9;
    for (const NearPeer& each : crowd) {
      const double apart = each.position.norm();
      if (chosen.contains(each.peer)) {
        farthest = std::max(farthest, apart);
      } else {
        next = std::min(next, apart);
      }
    }
    CHECK(farthest <= next + kSlack);
  }
  // Two at the border who change places by less than the slack, in each step.
  crowd = {{1, Vec3(1.0, 0.0, 0.0)}, {2, Vec3(4.0, 0.0, 0.0)}, {3, Vec3(4.1, 0.0, 0.0)}};
  Nearest two(2, kSlack);
  const auto first = set_of(two.choose(crowd, Vec3::Zero()));
  for (int step = 0; step < 100; ++step) {
    std::swap(crowd[1].position, crowd[2].position);
    CHECK(set_of(two.choose(crowd, Vec3::Zero())) == first);
  }
  crowd[2].position = Vec3(2.0, 0.0, 0.0);
  CHECK(set_of(two.choose(crowd, Vec3::Zero())) == std::set<PeerId>{1, 3});
}

}  // namespace
}  // namespace tandem::nats::nearest_test
