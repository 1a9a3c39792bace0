// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/replay_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/session_time.h"

namespace tandem::consensus {
namespace {

/// Steps of one body that are always allowed: if little moves, it is replayed anew in each step.
/// Tennis at profile 5 then goes on for 24 strokes in 20 s, and for 11 without.
constexpr double kMinSteps = 32.0;

/// Steps for which the last replay may be continued. With other peers' replays at other stamps 1000
/// balls over a cliff at profile 5 were 42 mm apart (p95) with 3, and 87 without a limit.
constexpr int kOldest = 3;

/// Steps whose unused budget may be saved: with steps and stamps at a regular rate, one replay per
/// period never needs as much. Tennis, profile 5, 60 and 72 steps a second: moving p95 126 mm, and
/// 195 if one step's is saved.
constexpr double kSavedSteps = 60.0;

/// Snapshots kept beyond the oldest one requested.
constexpr std::size_t kSpare = 4;

/// Number of the period of `length` s that contains a time: the same for all peers.
SessionTime period_of(SessionTime time, double length) {
  constexpr SessionTime kSecond = 1'000'000'000;
  constexpr SessionTime kPerSecond = 960;
  const SessionTime rest = time % kSecond * kPerSecond + kSecond / 2;
  const SessionTime units = std::max(1LL, std::llround(length * kPerSecond));
  return (time / kSecond * kPerSecond + rest / kSecond) / units;
}

}  // namespace

void Snapshots::resize(std::size_t count) {
  std::vector<Snapshot> other(count);
  // If two share a place, the newer one is kept.
  for (Snapshot& old : snapshots_) {
    Snapshot& place = other[old.frame % count];
    if (old.taken && (!place.taken || place.frame < old.frame)) std::swap(place, old);
  }
  snapshots_ = std::move(other);
}

bool Snapshots::keep(std::size_t frame, const pbd::World& world, bool rests,
                     const Springs& springs) {
  // A sleeping world is unchanged, unless sleepers were moved.
  const std::uint64_t moved = std::exchange(sleepers_moved_, world.sleepers_moved());
  if (rests && rests_ && moved == sleepers_moved_) return true;
  rests_ = rests;
  resting_since_ = frame;
  if (snapshots_.empty()) snapshots_.resize(kSpare);
  if (frame >= window_ + kWindow) {
    // Release what a late peer had requested.
    if (asked_ + kSpare < snapshots_.size() / 2) resize(asked_ + kSpare);
    window_ = frame;
    asked_ = 0;
  }
  Snapshot& snapshot = snapshots_[frame % snapshots_.size()];
  snapshot.frame = frame;
  snapshot.taken = snapshot.world.assign(world);
  snapshot.rows.clear();
  springs.rows(snapshot.rows);
  return snapshot.taken;
}

const Snapshots::Snapshot* Snapshots::find(std::size_t frame, std::size_t last) {
  if (snapshots_.empty()) return nullptr;
  if (rests_) frame = std::min(frame, resting_since_);
  asked_ = std::max(asked_, last - frame);
  const Snapshot& snapshot = snapshots_[frame % snapshots_.size()];
  if (snapshot.taken && snapshot.frame == frame) return &snapshot;
  const std::size_t count = std::min(kCapacity, last - frame + kSpare);
  if (count > snapshots_.size()) resize(count);
  return nullptr;
}

double ReplaySchedule::goes_back(double budget) { return (kOldest + 1.0) * budget - kOldest; }

bool ReplaySchedule::is_due(const WorldHistory& history, std::size_t start, std::size_t awake,
                            double budget) {
  const std::size_t now = history.last();
  const auto bodies = static_cast<double>(std::max<std::size_t>(awake, 1));
  budget = std::max(budget, kMinSteps / bodies);
  const auto age = static_cast<double>(now - start);
  const auto steps = static_cast<double>(now - std::exchange(seen_, now));
  saved_ = std::min(saved_ + steps * budget, std::max(kSavedSteps * budget, age));
  if (age <= budget) {
    saved_ -= age;
    return true;
  }
  // One fresh replay in `every` steps, continued in between, costs age + every - 1.
  double every = std::ceil((age - 1.0) / std::max(budget - 1.0, 1e-9));
  if (every > kOldest + 1.0) every = std::ceil((age + kOldest) / budget);
  const double step = seconds(history.frame(now).time - history.frame(now - 1).time);
  const SessionTime period = period_of(history.frame(start).time, every * step);
  if (std::exchange(period_, period) == period || saved_ < age) return false;
  saved_ -= age;
  return true;
}

bool ReplaySchedule::steps_along() {
  if (++old_ > kOldest) return false;
  saved_ -= 1.0;
  return true;
}

}  // namespace tandem::consensus
