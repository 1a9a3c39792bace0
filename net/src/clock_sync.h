// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>

#include "clock_filter.h"
#include "tandem/net/clock.h"

namespace tandem::net {

/// A peer's statement about its clock: a section of a packet.
struct ClockClaim {
  std::int64_t sent = 0;        // its own clock when it sent this, ns
  std::int64_t correction = 0;  // its session time minus its own clock then, ns
  std::int32_t rate = 0;        // of the correction, ppb
  std::uint32_t bound = 0;      // of its error, us; the largest number: that or more, or unknown
  std::uint8_t rank = 0;        // ClockSync::Rank
};

/// Session time at one peer: the local clock, which is never set, plus a correction that follows
/// the session time of one peer, the reference. The reference is the connected peer of the lowest
/// id among those of the highest rank that most others agree with. docs/protocol.md ("Session
/// time") has the rules. Times in ns; "own" is the steady clock.
class ClockSync {
 public:
  enum Rank : std::uint8_t { Fresh = 0, Alone = 1, Settled = 2 };
  static constexpr std::int64_t kSettling = 2'000'000'000;  // ns
  static constexpr std::int64_t kAloneAfter = 3'000'000'000;
  static constexpr double kMaxSlew = 500e-6;             // near the reference
  static constexpr double kMaxSlewFar = 5000e-6;         // if more than kFar is missing
  static constexpr std::int64_t kFar = 20'000'000;       // ns
  static constexpr std::int64_t kStale = 5'000'000'000;  // ns; silent for longer: no candidate

  /// @param follow  false: the correction is set by set_correction() alone, and the distance to the
  /// reference is measured
  ClockSync(consensus::PeerId self, bool follow, std::int64_t now, std::int64_t correction);

  /// An exchange with a connected peer. An impossible one is counted and ignored.
  void on_exchange(consensus::PeerId peer, const ClockSample& sample, const ClockClaim& claim);
  void lost(consensus::PeerId peer) { peers_.erase(peer); }
  /// Chooses the reference and the slew; call about every kUpdate.
  void update(std::int64_t now);
  static constexpr std::int64_t kUpdate = 50'000'000;
  void set_correction(std::int64_t correction, std::int64_t now);

  /// Session time at `now`; except for jumps it never decreases between calls.
  SessionTime now(std::int64_t now);
  /// Session time at a recent own time.
  SessionTime at(std::int64_t own) const { return own + correction(own); }
  ClockClaim claim(std::int64_t now) const;
  ClockStatus status(std::int64_t now);

 private:
  struct PeerClock {
    ClockFilter filter;
    ClockClaim claim;
    std::int64_t heard = 0;
  };
  struct Candidate {
    consensus::PeerId peer = 0;
    std::int64_t target = 0;  // its session time minus our own clock
    std::int64_t low = 0;
    std::int64_t high = 0;
    std::int64_t bound = 0;  // of its error, as it claims
  };

  std::int64_t correction(std::int64_t now) const;
  Candidate candidate(consensus::PeerId peer, const PeerClock& clock, std::int64_t now) const;
  Candidate choose(std::int64_t now) const;
  void follow(const Candidate& reference, std::int64_t now);
  void settle(bool together, std::int64_t now);

  consensus::PeerId self_;
  bool follow_;
  std::map<consensus::PeerId, PeerClock> peers_;
  std::int64_t start_;
  std::int64_t base_;     // correction at base_at_
  std::int64_t base_at_;  // then,
  double rate_ = 0.0;     // its rate since
  double drift_ = 0.0;    // part of the rate that is the local clock's error
  Rank rank_ = Fresh;
  std::int64_t together_since_ = INT64_MAX;
  bool jumped_ = false;
  std::int64_t drift_due_ = INT64_MIN;
  std::int64_t updated_ = INT64_MIN;
  SessionTime last_ = INT64_MIN;

  consensus::PeerId reference_ = 0;
  std::int64_t offset_ = 0;
  std::int64_t bound_ = 0;
  std::uint64_t jumps_ = 0;
  std::uint64_t faults_ = 0;
};

}  // namespace tandem::net
