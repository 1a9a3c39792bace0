// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "consensus/peer_fixture.h"
#include "replay/replay_start.h"
#include "support/catch.h"

namespace tandem::consensus::snapshots_test {
namespace {

using namespace testing;

TEST_CASE("replay: snapshots kept for a late peer are released later", "[consensus][fault]") {
  pbd::World world;
  world.add_body(ball(Vec3::Zero()));
  const PeerOptions options;
  Springs springs(world, options);
  Snapshots snapshots;
  std::size_t frame = 0;
  const auto keep = [&](std::size_t steps, std::size_t age) {
    for (std::size_t i = 0; i < steps; ++i) {
      snapshots.keep(++frame, world, false, springs);
      if (frame > age) snapshots.find(frame - age, frame);
    }
  };
  keep(100, 3);
  CHECK(snapshots.size() < 10);
  keep(100, 60);
  CHECK(snapshots.find(frame - 59, frame) != nullptr);
  CHECK(snapshots.size() > 60);
  keep(3 * Snapshots::kWindow, 3);
  CHECK(snapshots.size() < 10);
  // Snapshots that are still needed stay.
  CHECK(snapshots.find(frame - 3, frame) != nullptr);
  keep(2000, 1500);
  CHECK(snapshots.size() <= Snapshots::kCapacity);
}

}  // namespace
}  // namespace tandem::consensus::snapshots_test
