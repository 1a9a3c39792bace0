// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <tuple>

#include "session/participant.h"

namespace tandem::demos {

/// Session time at which runs in virtual time begin, ns: no stamp is 0 or negative.
inline constexpr consensus::SessionTime kVirtualStart = 1'000'000'000;

/// One peer of a run in virtual time. Who shares a clock steps at multiples of the step of the
/// session's time, as net::PhysicsClock does: peers of one rate step at the same times.
class Actor {
 public:
  /// @param number  from 0: its id is one more
  Actor(const Scenario& scenario, const DemoOptions& options, std::size_t number,
        consensus::Transport& transport);

  /// Time (ns) and kind of the next event; ends (0) come before beginnings (1).
  std::tuple<consensus::SessionTime, int> next() const {
    return inside_ ? std::tuple{step_time(step_ + 1), 0} : std::tuple{step_time(step_), 1};
  }
  void act();
  /// No step begins before `time` (ns), as of a program that the system has stopped.
  /// @pre its next event is the beginning of a step
  void sleep_until(consensus::SessionTime time);
  /// ns: the time of its world.
  consensus::SessionTime reached() const { return step_time(inside_ ? step_ + 1 : step_); }
  Participant& participant() { return *participant_; }
  const Participant& participant() const { return *participant_; }

 private:
  /// ns: where steps are off that grid, the first peer's begin at 0, the others' somewhere later.
  consensus::SessionTime phase(const DemoOptions& options, std::size_t number) const;
  consensus::SessionTime step_time(std::int64_t step) const;

  std::unique_ptr<Participant> participant_;
  consensus::SessionTime first_;
  std::int64_t step_ = 0;
  bool inside_ = false;  ///< the step is computed and waits for its end to come
};

/// Whose turn it is: by time, then ends of steps before beginnings, then peer. @pre not empty
std::size_t next_actor(std::span<const Actor> actors);

}  // namespace tandem::demos
