// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/solver.h"

/// Snapshots that somebody made up: the check value is right, the content is not.
namespace tandem::testing {

inline constexpr std::size_t kCheckBytes = 8;

/// `bytes` with those from `at` on replaced and the check value made anew.
inline std::vector<std::byte> forged(std::vector<std::byte> bytes, std::size_t at,
                                     std::span<const std::byte> with) {
  std::copy(with.begin(), with.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  bytes.resize(bytes.size() - kCheckBytes);
  pbd::ByteWriter(bytes).u64(pbd::hash_bytes(bytes));
  return bytes;
}

/// Whether the world refuses the bytes and is as it was, or takes them and can be stepped without
/// a body that leaves the numbers behind.
inline bool survives(pbd::World& world, std::span<const std::byte> bytes, bool& refused) {
  const auto before = world.snapshot();
  refused = false;
  try {
    world.restore(bytes);
  } catch (const std::invalid_argument&) {
    refused = true;
    return world.snapshot() == before;
  }
  pbd::Solver solver;
  for (int i = 0; i < 2; ++i) solver.step(world, 1.0 / 60.0);
  for (const pbd::BodyState& state : world.states()) {
    if (!state.pose.position.allFinite() || !state.twist.linear.allFinite()) return false;
  }
  return true;
}

}  // namespace tandem::testing
