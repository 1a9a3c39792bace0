// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/export.h"

namespace tandem::net {

using consensus::SessionTime;

/// Nanoseconds to seconds, for a solver that takes seconds.
constexpr double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

/// The time that all peers share: the system clock's when this object was made, ns since 1970, UTC,
/// continued by the steady clock. Processes on one host agree to microseconds; hosts agree as well
/// as NTP or PTP disciplines them (an error of dt displaces a body of speed v by v*dt: 1 ms is 5 mm
/// at 5 m/s). Both clocks are slewed alike.
///
/// Setting the system clock moves nothing in a running session; stepped() tells by how much it was
/// set. A process that starts afterwards differs by that amount.
///
/// The reading never goes back: while a custom source is behind the last reading, that reading is
/// held, and held() tells how far behind the source is.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API SessionClock {
 public:
  using Source = std::function<SessionTime()>;

  SessionClock();
  /// Reads `source` instead of the system clock. Throws std::invalid_argument if it is empty.
  explicit SessionClock(Source source);

  SessionTime now();
  /// How far the source was behind the reading at the last now(), ns, >= 0; 0 in normal operation.
  std::int64_t held() const { return held_; }
  /// How far the system clock is ahead of this one, ns: the amount by which it was set since
  /// construction. 0 with a custom source.
  std::int64_t stepped() const;

 private:
  Source source_;
  std::int64_t offset_ = 0;  ///< ns, of the steady clock
  bool steady_ = false;
  SessionTime last_ = INT64_MIN;
  std::int64_t held_ = 0;
};

/// Source of session time.
enum class Clock : std::uint8_t {
  /// The session's own timeline on steady clocks, agreed on in band: no host needs a disciplined
  /// clock.
  Session,
  /// The system clock: hosts are disciplined by PTP or NTP. Offsets to peers are measured, not
  /// followed.
  System,
  /// No common time: each peer has its own, and updates are dated on arrival
  /// (consensus::Packet::received less half of consensus::PeerStatus::round_trip).
  None,
};

/// How accurately session time is known. Times in ns.
struct TANDEM_API ClockStatus {
  SessionTime now = 0;
  /// Largest distance of `now` from the reference's session time, >= 0; -1 = unknown, with
  /// Clock::None. Certain for clocks that drift by less than 250 ppm, unequal delays included.
  std::int64_t error_bound = -1;
  std::int64_t offset = 0;          ///< the reference's session time less ours, as estimated
  consensus::PeerId reference = 0;  ///< the peer whose time it is, maybe this one; 0 = none yet
  bool synchronised = false;        ///< from then on it is slewed, never stepped
  std::uint64_t jumps = 0;          ///< steps so far, all before synchronisation
  std::uint64_t faults = 0;         ///< exchanges that no honest, steady clock explains
};

/// All times in ns.
struct TANDEM_API PhysicsClockOptions {
  std::int64_t nominal_step = 16'666'667;  ///< step when on time, > 0, at most a day
  std::int64_t max_step = 33'333'334;      ///< longest step, >= nominal_step, at most a day
  int max_steps_per_call = 8;              ///< in [1, PhysicsClock::kMaxSteps]
  /// A lag (either way) above this is skipped, not simulated; >= max_steps_per_call * max_step.
  std::int64_t stall_limit = 1'000'000'000;

  /// For `hz` steps a second, > 0: nominal_step, and limits raised where the defaults are too
  /// small.
  static PhysicsClockOptions at_rate(double hz);

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// Result of PhysicsClock::advance.
struct TANDEM_API ClockTick {
  /// Step lengths, ns, in order; valid until the next call.
  std::span<const std::int64_t> steps = {};
  std::int64_t skipped = 0;  ///< ns of shared time skipped before the steps
  std::int64_t lag = 0;      ///< shared time minus physics time after the steps, ns
  /// How far shared time is behind, ns, >= 0: nothing moves meanwhile. 0 in normal operation.
  std::int64_t held = 0;
};

/// Paces physics so that physics time stays just behind the shared time and never drifts from it
/// ([friston] Sec. 4.5). Pure: reads no clock and never blocks.
///
/// **Physics time is always a multiple of nominal_step.** So peers of one rate have states of the
/// same times, however their calls fall: they average the same states at a stamp, where states of
/// other times have to be interpolated (docs/method.md Sec. 5).
///
/// Policy, with lag = shared time - physics time at the call:
/// - lag < nominal_step: no step. On time: one step. After a call on time 0 <= lag < nominal_step.
/// - late: several steps; each is several times nominal_step, up to max_step, if max_steps_per_call
/// requires it. The rest is left to the next calls.
/// - lag > stall_limit (debugger, sleeping laptop): whole steps but the last one are skipped and
/// reported in `skipped`; bodies do not move meanwhile, but their time is right again.
/// - shared time behind physics time: no step until it has caught up; by more than stall_limit:
/// physics time is set back by whole steps and `skipped` is negative.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API PhysicsClock {
 public:
  static constexpr int kMaxSteps = 32;

  /// Physics time starts at the last multiple of nominal_step that is not after `start`. Throws
  /// std::invalid_argument (PhysicsClockOptions::validate).
  PhysicsClock(const PhysicsClockOptions& options, SessionTime start);

  /// The steps to do now, at shared time `now`. Physics time has advanced by them on return.
  ClockTick advance(SessionTime now);

  /// Start plus all steps plus all skips so far: the stamp of the present state.
  SessionTime physics_time() const { return time_; }
  /// Sum of all skips so far, ns.
  std::int64_t total_skipped() const { return total_skipped_; }
  /// Earliest shared time at which advance() returns a step: for a loop that sleeps.
  SessionTime next_due() const { return time_ + options_.nominal_step; }

 private:
  PhysicsClockOptions options_;
  SessionTime time_;
  std::int64_t total_skipped_ = 0;
  std::array<std::int64_t, kMaxSteps> steps_{};
};

}  // namespace tandem::net
