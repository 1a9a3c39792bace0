// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// Whose inputs a replay knows: the dial between feel and agreement, docs/method.md Sec. 8.
enum class ReplayInputs : std::uint8_t {
  /// Own hands as they truly were until now: what this user holds feels as if nobody else were
  /// there, and what two hold is further apart.
  Known,
  /// Of all hands what all peers know, up to the stamp, carried on alike: peers come to the same
  /// target, and what a user holds trails the own hand.
  Common,
};

/// How the mean at a common stamp is brought to the present, docs/method.md Secs. 5 and 6.
struct TANDEM_API ReplayOptions {
  /// Of the gap between a body and the replayed mean, closed per 1/60 s; above 0, at most 1. Who
  /// leads is followed with at least 0.5. A correction that begins starts with less, docs/method.md
  /// Sec. 6.
  double share = 0.25;
  ReplayInputs inputs = ReplayInputs::Known;
  /// Steps that may be replayed for each step of the world, in steps of the world as it is awake;
  /// at least 1; never less than 32 steps of one body. Infinity: a fresh replay in each step. With
  /// 4 a thousand balls 123.5 ms away take 15 to 21 ms of CPU for each step of 16.7 ms.
  double budget = 4.0;
  /// m: bodies that are no further from the mean, and by their velocities were not at the present
  /// either, are left alone. Rotations and spins count at a lever of 0.1 m.
  double tolerance = 2e-5;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Counts since the start.
struct TANDEM_API ReplayStats {
  std::uint64_t fresh = 0;      ///< replays that were begun at a stamp
  std::uint64_t postponed = 0;  ///< steps in which the old one was stepped along for want of budget
  std::uint64_t without = 0;    ///< steps in which even that was left out
  std::uint64_t steps = 0;      ///< of the scratch world
  std::uint64_t body_steps = 0;  ///< times the bodies that were awake in them
  double seconds = 0.0;          ///< CPU time
};

/// For applications that push bodies by code of their own, in a way that no replay can know.
class TANDEM_API ReplayHook {
 public:
  virtual ~ReplayHook() = default;
  /// A step of a replay is about to be made. What acted in the step of that time (forces, impulses,
  /// kinematic bodies, what was set) is in already. Slots are those of the peer's world. Nothing of
  /// it is seen or heard by anybody. Called from Peer::before_step; must not throw.
  virtual void before_step(pbd::World& scratch, SessionTime time, double dt) = 0;
};

}  // namespace tandem::consensus
