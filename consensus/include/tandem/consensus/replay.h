// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// Which hands a replay knows: trades feel against agreement, docs/method.md Sec. 8.
enum class ReplayInputs : std::uint8_t {
  /// The local hand as it truly was until now: a held body feels as if alone, and copies of a body
  /// that two users hold are further apart.
  Known,
  /// All hands, the local one too, up to the stamp and extrapolated alike: peers get the same
  /// target, and a held body lags the hand.
  Common,
};

/// How the mean at a common stamp is brought to the present, docs/method.md Secs. 5 and 6.
struct TANDEM_API ReplayOptions {
  /// Part of the gap between a body and the replayed mean that is closed per 1/60 s; above 0, at
  /// most 1. Towards a leader it is at least 1 - exp(-1 / (0.4 d)), d the age of its news in 1/60 s
  /// and at least 1. A correction that begins starts with less, docs/method.md Sec. 6.
  double share = 0.25;
  ReplayInputs inputs = ReplayInputs::Known;
  /// Replayed steps allowed for each step of the world, counted in steps of its awake bodies; at
  /// least 1; at least 32 steps of one body are always allowed. Infinity: a fresh replay in each
  /// step. With 4, a thousand balls at 123.5 ms take 15 to 21 ms of CPU for each step of 16.7 ms.
  double budget = 4.0;
  /// m: a body no further from the mean at the stamp, nor at present by extrapolation, is left
  /// alone. Rotations and spins count at a lever of 0.1 m.
  double tolerance = 2e-5;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Counts since the start.
struct TANDEM_API ReplayStats {
  std::uint64_t fresh = 0;       ///< replays that were begun at a stamp
  std::uint64_t postponed = 0;   ///< steps in which the old replay was continued for lack of budget
  std::uint64_t without = 0;     ///< steps in which even that was skipped
  std::uint64_t steps = 0;       ///< of the scratch world
  std::uint64_t body_steps = 0;  ///< the same, times the bodies awake in each
  double seconds = 0.0;          ///< CPU time
};

/// For applications that push bodies by their own code, which a replay cannot know.
class TANDEM_API ReplayHook {
 public:
  virtual ~ReplayHook() = default;
  /// Called before each step of a replay. Forces, impulses, kinematic bodies and set states of that
  /// time are already applied. Slots are those of the peer's world. Other peers and observers see
  /// nothing of it. Called from Peer::before_step; must not throw.
  virtual void before_step(pbd::World& scratch, SessionTime time, double dt) = 0;
};

}  // namespace tandem::consensus
