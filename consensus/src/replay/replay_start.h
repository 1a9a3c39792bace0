// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "input/springs.h"
#include "replay/world_history.h"
#include "tandem/pbd/world_copy.h"

/// Where and when a replay begins.
namespace tandem::consensus {

/// The world at the end of each of the last steps: possible starts of a replay.
class Snapshots {
 public:
  struct Snapshot {
    std::size_t frame = 0;
    bool taken = false;
    pbd::WorldCopy world;
    std::vector<pbd::ConstraintId> rows;  ///< of the springs' block
  };

  /// Take a snapshot, caches included. @param rests  nothing is awake
  /// @return whether the world can be copied
  bool keep(std::size_t frame, const pbd::World& world, bool rests, const Springs& springs);
  /// Null if it was not kept. The age kept is the longest one requested in about the last kWindow
  /// steps, at most kCapacity.
  /// @param last  the newest frame
  const Snapshot* find(std::size_t frame, std::size_t last);

  std::size_t size() const { return snapshots_.size(); }

  static constexpr std::size_t kCapacity = 256;  ///< the longest age at 240 steps a second
  static constexpr std::size_t kWindow = 300;    ///< steps

 private:
  void resize(std::size_t count);

  std::vector<Snapshot> snapshots_;  ///< by frame, a ring
  std::size_t asked_ = 0;            ///< frames, longest age requested since window_
  std::size_t window_ = 0;           ///< frame
  std::size_t resting_since_ = 0;    ///< frame since which nothing has moved
  bool rests_ = false;
  std::uint64_t sleepers_moved_ = 0;  ///< of the world, when it was last kept
};

/// Decides when a replay is begun anew. All peers begin at the same stamps, so that they get the
/// same target.
class ReplaySchedule {
 public:
  /// Steps: if the news are no older, every step has a target, by a new replay or by the last one.
  static double goes_back(double budget);
  /// Whether the budget allows a new replay now.
  /// @param start  frame at which it would begin    @param awake  bodies, of the local world
  bool is_due(const WorldHistory& history, std::size_t start, std::size_t awake, double budget);
  /// A replay was begun.
  void begun() { old_ = 0; }
  bool is_fresh() const { return old_ == 0; }
  /// Whether the last replay may be continued for one step; counts that step.
  bool steps_along();

 private:
  int old_ = 0;              ///< steps since the last replay was begun
  SessionTime period_ = -1;  ///< period of the start of the last replay
  /// Allowed steps that were not made. When the age of news changes, so does the length of a
  /// period, and replays begin more often than the budget allows.
  double saved_ = std::numeric_limits<double>::infinity();
  std::size_t seen_ = 0;  ///< frame up to which saved_ is known
};

}  // namespace tandem::consensus
