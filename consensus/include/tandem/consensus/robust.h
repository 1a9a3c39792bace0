// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// How far a member is believed that the transport has authenticated. What it may do all the same
/// is in docs/protocol.md; of two peers neither can be shown to lie.
struct TANDEM_API RobustOptions {
  /// With two or more others, what is said far from the rest counts less, this peer's own copy
  /// being one of the votes, and nobody counts more than the next one: one of three or more who
  /// says something else, whatever it is, moves a body no further than the others are apart. Where
  /// somebody leads a body and has reason to, only those count, or nobody could move anything.
  /// Needs a mesh: who hears two neighbours of a long chain cannot tell who is far from the rest.
  bool outvote = true;
  /// Most that agreement asks for in 1/60 s; not of the state of an owner. Infinity = no limit.
  double max_correction = 0.25;           ///< m
  double max_turn = 1.0;                  ///< rad
  double max_velocity_correction = 50.0;  ///< m/s
  double max_spin_correction = 200.0;     ///< rad/s

  /// Of one other peer. How strong users' springs may be is the same for all, docs/protocol.md.
  int max_springs_per_body = 16;
  /// m/s: users' springs, own ones too, make a body no faster than this towards the hand, and acts
  /// at all; all peers of a session need the same. Infinity = no limit.
  double max_pull_speed = 10.0;
  /// m: others' hands that are further from what they hold are let go: who is not near holds
  /// nothing.
  double max_reach = 100.0;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// What came of the states that were received.
struct TANDEM_API InboxCounters {
  std::uint64_t accepted = 0;
  std::uint64_t duplicate = 0;     ///< same stamp as the one kept
  std::uint64_t late = 0;          ///< older than the one kept
  std::uint64_t expired = 0;       ///< older than max_age
  std::uint64_t future = 0;        ///< stamped more than max_future ahead
  std::uint64_t implausible = 0;   ///< nothing moves like that, see plausible()
  std::uint64_t unknown_id = 0;    ///< not shared here
  std::uint64_t unknown_peer = 0;  ///< it has left

  std::uint64_t dropped() const;
  friend bool operator==(const InboxCounters&, const InboxCounters&) = default;
};

/// What one other peer has sent and what was done about it, since it was first heard.
struct TANDEM_API PeerReport {
  PeerId peer = 0;
  InboxCounters inbox = {};  ///< of its states
  /// Steps in which its states were left out where others spoke: so much older than theirs that a
  /// replay from there would have been everybody's cost.
  std::uint64_t late = 0;
  /// Steps without a target (ReplayStats::without), since its states are so old.
  std::uint64_t without = 0;
  std::uint64_t outliers = 0;         ///< steps times bodies: far from what the others say
  std::uint64_t capped = 0;           ///< steps times bodies: it alone asked for too much
  std::uint64_t influence_cut = 0;    ///< steps times bodies: claimed more than others may
  std::uint64_t unfounded_leads = 0;  ///< steps times bodies: says it leads, and holds nothing
  std::uint64_t springs_limited = 0;  ///< messages whose strength or speed was cut
  std::uint64_t springs_refused = 0;  ///< messages: too many, too far, unknown body
  std::uint64_t acts_refused = 0;     ///< too many, too old, unknown or owned body
  std::uint64_t over_budget = 0;      ///< packets that were not looked at: it had sent too much
  std::uint64_t not_allowed = 0;      ///< states, springs and the like that its role forbids
};

}  // namespace tandem::consensus
