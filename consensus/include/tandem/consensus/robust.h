// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// How far an authenticated member is believed. docs/protocol.md says what it can still do; of two
/// peers that disagree neither can be shown to lie.
struct TANDEM_API RobustOptions {
  /// With two or more other peers, states far from the rest count less, the local copy being one
  /// vote, and no peer counts more than the next one. So among three or more one dissenter,
  /// whatever it claims, moves a body no further than the others are apart. If a peer leads a body
  /// with good reason, only leaders count, or nobody could move anything. Needs a full mesh: a peer
  /// that hears only two neighbours of a long chain cannot tell which is the outlier.
  bool outvote = true;
  /// Largest correction in 1/60 s; not for an owner's state. Infinity = no limit.
  double max_correction = 0.25;           ///< m
  double max_turn = 1.0;                  ///< rad
  double max_velocity_correction = 50.0;  ///< m/s
  double max_spin_correction = 200.0;     ///< rad/s

  /// Limit for one other peer. The strength of users' springs has one limit for all,
  /// docs/protocol.md.
  int max_springs_per_body = 16;
  /// m/s: users' springs, own ones too, make a body no faster than this towards the hand, and acts
  /// no faster in any direction; all peers of a session need the same value. Infinity = no limit.
  double max_pull_speed = 10.0;
  /// m: others' springs whose hand is further from the body are released.
  double max_reach = 100.0;

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Outcome of the states received.
struct TANDEM_API InboxCounters {
  std::uint64_t accepted = 0;
  std::uint64_t duplicate = 0;     ///< same stamp as the stored one
  std::uint64_t late = 0;          ///< older than the stored one
  std::uint64_t expired = 0;       ///< older than max_age
  std::uint64_t future = 0;        ///< stamped more than max_future ahead
  std::uint64_t implausible = 0;   ///< no body moves like that, see plausible()
  std::uint64_t unknown_id = 0;    ///< not shared here
  std::uint64_t unknown_peer = 0;  ///< the sender has left

  std::uint64_t dropped() const;
  friend bool operator==(const InboxCounters&, const InboxCounters&) = default;
};

/// Counts for one other peer since it was first heard.
struct TANDEM_API PeerReport {
  PeerId peer = 0;
  InboxCounters inbox = {};  ///< of its states
  /// Steps in which its states were ignored in favour of others': they were so much older that
  /// replaying from them would have cost everybody.
  std::uint64_t late = 0;
  /// Steps without a target (ReplayStats::without) because its states were so old.
  std::uint64_t without = 0;
  std::uint64_t outliers = 0;         ///< steps times bodies: far from the others' states
  std::uint64_t capped = 0;           ///< steps times bodies: too large a correction, by it alone
  std::uint64_t influence_cut = 0;    ///< steps times bodies: claimed too much influence
  std::uint64_t unfounded_leads = 0;  ///< steps times bodies: led without having held it
  std::uint64_t springs_limited = 0;  ///< messages whose strength or speed was cut
  std::uint64_t springs_refused = 0;  ///< messages: too many, too far, unknown body
  std::uint64_t acts_refused = 0;     ///< too many, too old, unknown or owned body
  std::uint64_t over_budget = 0;      ///< packets not decoded: it had sent too much
  std::uint64_t not_allowed = 0;      ///< states, springs and the like that its role forbids
};

}  // namespace tandem::consensus
