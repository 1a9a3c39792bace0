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

/// Where a replay begins, and when.
namespace tandem::consensus {

/// The world as it was at the end of each of the last steps: what a replay may begin with.
class Snapshots {
 public:
  struct Snapshot {
    std::size_t frame = 0;
    bool taken = false;
    pbd::WorldCopy world;
    std::vector<pbd::ConstraintId> rows;  ///< of the springs' block
  };

  /// Keep the world as it is, caches and all. @param rests  nothing is awake
  /// @return whether it can be copied
  bool keep(std::size_t frame, const pbd::World& world, bool rests, const Springs& springs);
  /// Null where it was not kept: worlds are kept for as long as they have been asked for in the
  /// last kWindow steps or so, and no more than kCapacity.
  /// @param last  the newest frame
  const Snapshot* find(std::size_t frame, std::size_t last);

  std::size_t size() const { return snapshots_.size(); }

  static constexpr std::size_t kCapacity = 256;  ///< the longest age at 240 steps a second
  static constexpr std::size_t kWindow = 300;    ///< steps

 private:
  void resize(std::size_t count);

  std::vector<Snapshot> snapshots_;  ///< by frame, a ring
  std::size_t asked_ = 0;            ///< frames, longest age that was asked for since window_
  std::size_t window_ = 0;           ///< frame
  std::size_t resting_since_ = 0;    ///< frame from which on nothing has moved
  bool rests_ = false;
  std::uint64_t sleepers_moved_ = 0;  ///< of the world, when it was last kept
};

/// When a replay is begun anew. All peers begin theirs at the same stamps, so that they go for the
/// same target.
class ReplaySchedule {
 public:
  /// Steps: with news that are no older every step has a target, of a new replay or of the last
  /// one.
  static double goes_back(double budget);
  /// Whether a budget allows for a new replay now.
  /// @param start  frame at which it would begin    @param awake  bodies, of the own world
  bool is_due(const WorldHistory& history, std::size_t start, std::size_t awake, double budget);
  /// It has been begun.
  void begun() { old_ = 0; }
  bool is_fresh() const { return old_ == 0; }
  /// Whether the last one may be stepped along once more, which it then is.
  bool steps_along();

 private:
  int old_ = 0;              ///< steps since the last replay was begun
  SessionTime period_ = -1;  ///< in which the last replay starts
  /// Steps that the budget has allowed for and that were not made: where the age of news changes,
  /// so does the length of a period, and a new one begins more often than the budget has it.
  double saved_ = std::numeric_limits<double>::infinity();
  std::size_t seen_ = 0;  ///< frame up to which that is known
};

}  // namespace tandem::consensus
